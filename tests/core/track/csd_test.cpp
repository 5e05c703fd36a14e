// SPDX-License-Identifier: LGPL-2.1-or-later
#include "track/csd.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>

#include "track/moving_scene.h"
#include "track/thread_pool.h"
#include "track/tracker.h"

namespace csd {
namespace {

constexpr std::int64_t frame_time = second / 25;

cv::Point2d sway(int frame) {
  return {9 * std::sin(frame * 0.15), 6 * std::sin(frame * 0.1)};
}

Settings at(std::vector<cv::Point2d> points) {
  Settings settings;
  settings.algorithm = AlgorithmKind::csd;
  settings.points = std::move(points);
  settings.content_area = ContentArea::full;
  return settings;
}

using Scene = std::function<cv::Mat(int)>;

std::vector<Tracks> run(const Settings &settings, int frames, const Scene &scene) {
  ThreadPool pool(1);
  Tracker tracker(settings, pool);
  std::vector<Tracks> all;
  for (int i = 0; i < frames; ++i) {
    const auto picture = scene(i);
    all.push_back(tracker.process(MovingScene::view(picture), i * frame_time));
  }
  return all;
}

cv::Mat swaying(int frame) {
  static const MovingScene scene;
  return scene.render(sway(frame));
}

bool claims(const Feature &f) {
  return f.state == FeatureState::learning || f.state == FeatureState::tracked;
}

double error(const Feature &f, cv::Point2d start, int frame) {
  const auto there = start + sway(frame) - sway(0);
  return std::hypot(f.x - there.x, f.y - there.y);
}

const std::vector<cv::Point2d> some{{60, 60}, {160, 120}, {250, 70}, {90.5, 180.25}, {240, 170}};

TEST(Csd, FollowsTheTextureClosely) {
  const auto all = run(at(some), 60, swaying);
  for (int i = 0; i < 60; ++i)
    for (const auto &f : all[static_cast<std::size_t>(i)].features) {
      EXPECT_TRUE(claims(f)) << f.id << " in frame " << i;
      EXPECT_LT(error(f, some[f.id], i), 0.3) << f.id << " in frame " << i;
      // Half a second and its frame.
      if (i != 12 && i != 13) {
        EXPECT_EQ(f.state, i < 12 ? FeatureState::learning : FeatureState::tracked) << i;
      }
    }
}

TEST(Csd, OnePointHasTheSameTrackAsAmongMany) {
  std::vector<cv::Point2d> many;
  for (int i = 0; i < 100; ++i) many.emplace_back(25 + 30 * (i % 10), 20 + 22 * (i / 10));
  const auto among = run(at(many), 40, swaying), alone = run(at({many[44]}), 40, swaying);
  for (std::size_t i = 0; i < 40; ++i) {
    const auto &a = among[i].features[44], &b = alone[i].features[0];
    EXPECT_EQ(a.x, b.x);
    EXPECT_EQ(a.y, b.y);
    EXPECT_EQ(a.state, b.state);
    EXPECT_EQ(a.confidence, b.confidence);
  }
}

TEST(Csd, ClaimsExactlyWhatItBelieves) {
  // A lid comes over the right half.
  const auto all = run(at(some), 50, [](int frame) {
    auto picture = swaying(frame);
    if (frame >= 20 && frame < 40) picture.colRange(150, 320).setTo(cv::Scalar(60, 60, 60));
    return picture;
  });
  int hidden = 0;
  for (std::size_t i = 0; i < all.size(); ++i)
    for (const auto &f : all[i].features) {
      EXPECT_EQ(claims(f), f.confidence >= 0.5);
      if (i >= 20 && i < 40 && some[f.id].x > 200) hidden += !claims(f);
    }
  EXPECT_EQ(hidden, 2 * 20);
  for (const auto &f : all[42].features) {
    EXPECT_TRUE(claims(f)) << f.id;
    EXPECT_LT(error(f, some[f.id], 42), 0.5);
  }
}

TEST(Csd, IsSilentInBlackAndInAnotherScene) {
  const MovingScene other({320, 240}, 9);
  const auto all = run(at(some), 80, [&](int frame) {
    if (frame >= 20 && frame < 40) return cv::Mat(cv::Mat::zeros(240, 320, CV_8UC3));
    return frame >= 40 && frame < 70 ? other.render(sway(frame)) : swaying(frame);
  });
  for (std::size_t i = 20; i < 70; ++i)
    for (const auto &f : all[i].features) EXPECT_FALSE(claims(f)) << f.id << " in frame " << i;
  for (const auto &f : all[75].features) {
    EXPECT_TRUE(claims(f)) << f.id;
    EXPECT_LT(error(f, some[f.id], 75), 0.5);
  }
}

TEST(Csd, KeepsItsPixelConstantsAtOtherSizes) {
  // The same scene at twice the size: the same tracks, twice as far apart.
  const auto large = [](int frame) {
    cv::Mat out;
    cv::resize(swaying(frame), out, {}, 2, 2, cv::INTER_CUBIC);
    return out;
  };
  std::vector<cv::Point2d> doubled;
  for (const auto &p : some) doubled.push_back(2 * p + cv::Point2d(0.5, 0.5));
  const auto all = run(at(doubled), 30, large);
  for (const auto &f : all[29].features) {
    const auto there = doubled[f.id] + 2 * (sway(29) - sway(0));
    EXPECT_TRUE(claims(f));
    EXPECT_LT(std::hypot(f.x - there.x, f.y - there.y), 0.6) << f.id;
  }
}

TEST(Csd, ReplenishesAndForgets) {
  Settings settings = at({});
  settings.max_features = 20;
  ThreadPool pool(1);
  Tracker tracker(settings, pool);
  for (int i = 0; i < 5; ++i) {
    const auto picture = swaying(i);
    tracker.process(MovingScene::view(picture), i * frame_time);
  }
  const auto first = tracker.stats().detected;
  EXPECT_EQ(first, 20u);
  tracker.reset();
  for (int i = 5; i < 8; ++i) {
    const auto picture = swaying(i);
    const auto &tracks = tracker.process(MovingScene::view(picture), i * frame_time);
    if (i == 7) {
      ASSERT_FALSE(tracks.features.empty());
      for (const auto &f : tracks.features) EXPECT_TRUE(f.id >= first && claims(f)) << f.id;
    }
  }
}

}  // namespace
}  // namespace csd
