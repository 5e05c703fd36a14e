// SPDX-License-Identifier: LGPL-2.1-or-later
#include "programs/peers/peer.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "track/moving_scene.h"

namespace csd::peers {
namespace {

const std::vector<cv::Point2d> points{{160, 120}, {100.5, 80.25}, {220, 150}, {90, 170}, {240, 70}};
constexpr int frames = 20;

cv::Point2d shift_of(int frame) {
  return {0.9 * frame, -0.6 * frame};
}

std::unique_ptr<Peer> made(std::string_view name) {
  return find_peer(name)->make();
}

class APeer : public testing::TestWithParam<PeerKind> {};

TEST_P(APeer, FollowsARigidScene) {
  const MovingScene scene;
  const bool still = GetParam().name == "still";
  // Boxes have whole pixels and change size.
  const bool flow = GetParam().name.substr(0, 2) == "lk" || GetParam().name == "medianflow";
  const auto peer = GetParam().make();
  peer->start({scene.render({0, 0})}, points);
  int right = 0, wrong = 0;
  for (int i = 1; i <= frames; ++i) {
    const auto reports = peer->follow({scene.render(shift_of(i))});
    ASSERT_EQ(reports.size(), points.size());
    for (std::size_t k = 0; k < points.size(); ++k) {
      if (!reports[k].seen) continue;
      ++(cv::norm(reports[k].position - points[k] - shift_of(i)) <= (flow ? 1 : 3) ? right : wrong);
    }
  }
  const int all = frames * static_cast<int>(points.size());
  if (still) {
    EXPECT_EQ(right, 2 * static_cast<int>(points.size()));  // moves by 1.08 pixels a frame: 1.1, 2.2, 3.2
    EXPECT_EQ(wrong, all - right);
  } else {
    EXPECT_GE(right, all * 9 / 10);
    EXPECT_LE(wrong, all / 20);
  }
}

TEST_P(APeer, AcceptsPointsAtTheEdge) {
  const MovingScene scene;
  const auto peer = GetParam().make();
  const std::vector<cv::Point2d> edge{{0, 0}, {319, 239}, {-0.4, 120}, {160, 2}};
  peer->start({scene.render({0, 0})}, edge);
  for (int i = 1; i <= 5; ++i) {
    const auto reports = peer->follow({scene.render(shift_of(-i))});
    ASSERT_EQ(reports.size(), edge.size());
    for (const auto &r : reports) {
      EXPECT_TRUE(std::isfinite(r.position.x));
      EXPECT_TRUE(std::isfinite(r.position.y));
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Peers, APeer, testing::ValuesIn(peer_kinds().begin(), peer_kinds().end()),
                         [](const auto &info) {
                           std::string name(info.param.name);
                           std::replace(name.begin(), name.end(), '-', '_');
                           return name;
                         });

const cv::Mat flat(240, 320, CV_8UC3, cv::Scalar(80, 80, 80));

/// How many are found in the scene's first picture after an empty one.
int seen_again(std::string_view name) {
  const MovingScene scene;
  const auto peer = made(name);
  peer->start({scene.render({0, 0})}, points);
  for (const auto &r : peer->follow({flat})) EXPECT_FALSE(r.seen);
  peer->follow({scene.render({0, 0})});
  int seen = 0;
  for (const auto &r : peer->follow({scene.render({0, 0})})) seen += r.seen;
  return seen;
}

TEST(CheckedFlow, NeverFindsALostPointAgain) {
  EXPECT_EQ(seen_again("lk-fb"), 0);
}

TEST(AnchoredFlow, FindsALostPointAgain) {
  EXPECT_EQ(seen_again("lk-anchored"), static_cast<int>(points.size()));
}

/// The mean error in the last ten of 80 noisy pictures. Chained steps add up their errors.
double late_error(std::string_view name) {
  const MovingScene scene;
  const auto peer = made(name);
  cv::RNG rng(11);
  const auto noisy = [&](cv::Point2d shift) {
    cv::Mat noise(240, 320, CV_16SC3), sum;
    rng.fill(noise, cv::RNG::NORMAL, 0, 6);
    cv::add(scene.render(shift), noise, sum, cv::noArray(), CV_8U);
    return sum;
  };
  peer->start({noisy({0, 0})}, points);
  double error = 0;
  int n = 0;
  for (int i = 1; i <= 80; ++i) {
    const cv::Point2d shift(3 * std::sin(0.7 * i), 3 * std::cos(0.5 * i) - 3);
    const auto reports = peer->follow({noisy(shift)});
    for (std::size_t k = 0; i > 70 && k < points.size(); ++k) {
      if (!reports[k].seen) continue;
      error += cv::norm(reports[k].position - points[k] - shift);
      ++n;
    }
  }
  EXPECT_EQ(n, 10 * static_cast<int>(points.size())) << name;
  return error / n;
}

TEST(AnchoredFlow, DoesNotDrift) {
  const double chained = late_error("lk-fb"), anchored = late_error("lk-anchored");
  EXPECT_LT(anchored, chained / 2) << chained;
  EXPECT_LT(anchored, 0.2);
}

TEST(Peers, LengthsGrowOnlyWithLargePictures) {
  EXPECT_EQ(odd_length(21, cv::Mat(240, 320, CV_8UC1)), 21);
  EXPECT_EQ(odd_length(21, cv::Mat(576, 720, CV_8UC1)), 21);
  EXPECT_EQ(odd_length(21, cv::Mat(1152, 1440, CV_8UC1)), 43);  // 42 lies between 41 and 43
  EXPECT_EQ(odd_length(29, cv::Mat(1080, 1920, CV_8UC1)), 55);  // 54.4
}

TEST(Peers, AreFoundByName) {
  EXPECT_EQ(find_peer("kcf")->name, "kcf");
  EXPECT_EQ(find_peer("KCF"), nullptr);
  EXPECT_EQ(find_peer(""), nullptr);
}

}  // namespace
}  // namespace csd::peers
