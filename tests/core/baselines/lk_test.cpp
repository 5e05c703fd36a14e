// SPDX-License-Identifier: LGPL-2.1-or-later
#include "baselines/lk.h"

#include <gtest/gtest.h>

#include <cmath>

#include "track/moving_scene.h"
#include "track/tracker.h"

namespace csd {
namespace {

class NoExecutor final : public Executor {
  void post(std::function<void()>) override { FAIL() << "LK learns nothing"; }
};

Settings lk(std::vector<cv::Point2d> points) {
  Settings settings;
  settings.algorithm = AlgorithmKind::lk;
  settings.points = std::move(points);
  return settings;
}

TEST(LucasKanade, FollowsToAFractionOfAPixel) {
  NoExecutor none;
  const MovingScene scene;
  Tracker tracker(lk({{160, 120}, {90.5, 70.25}}), none);
  for (int i = 0; i <= 20; ++i) {
    const auto picture = scene.render({0.7 * i, -0.4 * i});
    const auto &tracks = tracker.process(MovingScene::view(picture), i * second / 25);
    for (const auto &f : tracks.features) {
      EXPECT_EQ(f.state, FeatureState::tracked);
      EXPECT_NEAR(f.x, (f.id == 0 ? 160 : 90.5) + 0.7 * i, 0.3);
      EXPECT_NEAR(f.y, (f.id == 0 ? 120 : 70.25) - 0.4 * i, 0.3);
    }
  }
}

TEST(LucasKanade, OverTheEdgeIsOutAndStaysOut) {
  NoExecutor none;
  const MovingScene scene;
  Tracker tracker(lk({{314, 120}}), none);
  FeatureState state{};
  for (int i = 0; i <= 20; ++i)
    state = tracker.process(MovingScene::view(scene.render({0.8 * i, 0})), i * second / 25).features.at(0).state;
  EXPECT_EQ(state, FeatureState::out);
  for (int i = 0; i <= 5; ++i)
    state = tracker.process(MovingScene::view(scene.render({0, 0})), (21 + i) * second / 25).features.at(0).state;
  EXPECT_EQ(state, FeatureState::out);
}

TEST(LucasKanade, WhatIsLostIsLostForEver) {
  NoExecutor none;
  const MovingScene scene;
  Tracker tracker(lk({{160, 120}}), none);
  const auto picture = scene.render({0, 0});
  const cv::Mat flat(240, 320, CV_8UC3, cv::Scalar(80, 80, 80));
  tracker.process(MovingScene::view(picture), 0);
  EXPECT_EQ(tracker.process(MovingScene::view(flat), second / 25).features.at(0).state, FeatureState::lost);
  EXPECT_EQ(tracker.process(MovingScene::view(picture), 2 * second / 25).features.at(0).state, FeatureState::lost);
  EXPECT_EQ(tracker.process(MovingScene::view(picture), 3 * second / 25).features.at(0).state, FeatureState::lost);
}

}  // namespace
}  // namespace csd
