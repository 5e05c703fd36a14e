// SPDX-License-Identifier: LGPL-2.1-or-later
#include "baselines/collins.h"

#include <gtest/gtest.h>

#include <cmath>

#include "algorithms/make_algorithm.h"
#include "track/moving_scene.h"
#include "track/tracker.h"

namespace csd {
namespace {

class NoExecutor final : public Executor {
  void post(std::function<void()>) override { FAIL() << "mean shift posts no jobs"; }
};

const cv::Scalar green(60, 160, 60), darker(40, 110, 50);

/// A blob of two greens on the red scene, turned by `angle` (radians). It is as large as a patch at 240 lines, 11 wide:
/// in a larger blob a window could lag behind without losing weight.
void draw_blob(cv::Mat &picture, cv::Point2d at, double angle = 0) {
  for (int y = -5; y <= 5; ++y)
    for (int x = -5; x <= 5; ++x) {
      const cv::Point p(cvRound(at.x) + x, cvRound(at.y) + y);
      if (x * x + y * y > 30 || !p.inside({0, 0, picture.cols, picture.rows})) continue;
      const auto &c = std::cos(angle) * x + std::sin(angle) * y > 0 ? green : darker;
      picture.at<cv::Vec3b>(p) = cv::Vec3b(cv::saturate_cast<std::uint8_t>(c[0]), cv::saturate_cast<std::uint8_t>(c[1]),
                                           cv::saturate_cast<std::uint8_t>(c[2]));
    }
}

class Collins : public testing::TestWithParam<AlgorithmKind> {
 protected:
  Tracker tracker(std::vector<cv::Point2d> points, AlgorithmKind algorithm) {
    Settings settings;
    settings.algorithm = algorithm;
    settings.points = std::move(points);
    settings.content_area = ContentArea::full;
    return {settings, make_algorithm(settings, none_)};
  }
  Tracker tracker(std::vector<cv::Point2d> points) { return tracker(std::move(points), GetParam()); }

  /// The distance between the feature and the truth.
  static double error(const Feature &f, cv::Point2d truth) { return std::hypot(f.x - truth.x, f.y - truth.y); }

  NoExecutor none_;
  MovingScene scene_;
};

TEST_P(Collins, FollowsABlobOfItsOwnColourWithItsScene) {
  auto t = tracker({{160, 120}});
  for (int i = 0; i <= 30; ++i) {
    const cv::Point2d shift(1.2 * i, -0.9 * i);
    auto picture = scene_.render(shift);
    const auto at = cv::Point2d(160, 120) + shift;
    draw_blob(picture, at);
    const auto &f = t.process(MovingScene::view(picture), i * second / 25).features.at(0);
    EXPECT_EQ(f.state, FeatureState::tracked);
    EXPECT_EQ(f.confidence, 1);
    EXPECT_LT(error(f, at), 1.5) << i;
  }
}

TEST_P(Collins, FollowsARotatingBlob) {
  auto t = tracker({{160, 120}});
  for (int i = 0; i <= 30; ++i) {
    auto picture = scene_.render({0, 0});
    draw_blob(picture, {160, 120}, i * CV_PI / 15);
    const auto &f = t.process(MovingScene::view(picture), i * second / 25).features.at(0);
    EXPECT_EQ(f.state, FeatureState::tracked);
    EXPECT_LT(error(f, {160, 120}), 2) << i;
  }
}

// §3.1: before and after a displacement, the feature must overlap itself.
TEST_P(Collins, LosesAJumpingBlobAndFindsItAtItsOldPlace) {
  auto t = tracker({{160, 120}});
  const auto see = [&](int i, cv::Point2d at) {
    auto picture = scene_.render({0, 0});
    draw_blob(picture, at);
    return t.process(MovingScene::view(picture), i * second / 25).features.at(0);
  };
  for (int i = 0; i < 5; ++i) EXPECT_EQ(see(i, {160, 120}).state, FeatureState::tracked);
  const auto gone = see(5, {220, 120});
  EXPECT_EQ(gone.state, FeatureState::occluded);
  EXPECT_EQ(gone.confidence, 0);
  EXPECT_LT(error(gone, {160, 120}), 2);
  EXPECT_EQ(see(40, {220, 120}).state, FeatureState::lost);
  EXPECT_EQ(see(41, {163, 120}).state, FeatureState::tracked);
}

// §3.1: "colour in MIS images is not sufficient to distinguish the feature from its surroundings". The scene has enough
// texture for LK, but the same colours everywhere.
TEST_P(Collins, DriftsWhereColoursAreTheSameEverywhere) {
  std::vector<cv::Point2d> points;
  for (int y = 80; y <= 160; y += 16)
    for (int x = 100; x <= 220; x += 16) points.emplace_back(x, y);
  auto ours = tracker(points), lk = tracker(points, AlgorithmKind::lk);
  int wrong = 0, wrong_lk = 0;
  for (int i = 0; i <= 30; ++i) {
    const cv::Point2d shift(1.2 * i, -0.9 * i);
    cv::Mat gray, picture;
    cv::cvtColor(scene_.render(shift), gray, cv::COLOR_BGR2GRAY);
    cv::equalizeHist(gray, gray);
    cv::cvtColor(gray, picture, cv::COLOR_GRAY2BGR);
    const auto count = [&](Tracker &t) {
      int n = 0;
      for (const auto &f : t.process(MovingScene::view(picture), i * second / 25).features)
        n += error(f, points[f.id] + shift) > 5;
      return n;
    };
    wrong = count(ours);
    wrong_lk = count(lk);
  }
  EXPECT_EQ(wrong_lk, 0);
  EXPECT_GT(wrong, static_cast<int>(points.size()) / 3);
}

TEST_P(Collins, FindsNothingWithoutContrast) {
  auto t = tracker({{160, 120}});
  const cv::Mat flat(240, 320, CV_8UC3, cv::Scalar(80, 90, 120));
  t.process(MovingScene::view(flat), 0);
  EXPECT_EQ(t.process(MovingScene::view(flat), second / 25).features.at(0).state, FeatureState::occluded);
}

TEST_P(Collins, IsOutForGoodOnceOverTheEdge) {
  auto t = tracker({{300, 120}});
  FeatureState state{};
  const auto see = [&](int i, double x) {
    auto picture = scene_.render({0, 0});
    draw_blob(picture, {x, 120});
    return t.process(MovingScene::view(picture), i * second / 25).features.at(0).state;
  };
  for (int i = 0; i <= 24; ++i) state = see(i, 300 + i);
  EXPECT_EQ(state, FeatureState::out);
  for (int i = 25; i <= 40; ++i) state = see(i, 300);
  EXPECT_EQ(state, FeatureState::out);
}

TEST_P(Collins, FollowsEachFeatureAsIfAlone) {
  const std::vector<cv::Point2d> points{{160, 120}, {100, 80}, {220, 150}};
  auto all = tracker(points), one = tracker({points[2]});
  for (int i = 0; i <= 15; ++i) {
    const auto picture = scene_.render({0.8 * i, 0.3 * i});
    const auto a = all.process(MovingScene::view(picture), i * second / 25).features.at(2);
    const auto b = one.process(MovingScene::view(picture), i * second / 25).features.at(0);
    EXPECT_EQ(a.x, b.x);
    EXPECT_EQ(a.y, b.y);
    EXPECT_EQ(a.state, b.state);
  }
}

INSTANTIATE_TEST_SUITE_P(Baselines, Collins, testing::Values(AlgorithmKind::ms1, AlgorithmKind::ms2),
                         [](const auto &info) { return std::string(algorithm_name(info.param)); });

}  // namespace
}  // namespace csd
