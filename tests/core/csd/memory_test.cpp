// SPDX-License-Identifier: LGPL-2.1-or-later
#include "csd/memory.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/csd/scene.h"

namespace csd {
namespace {

const AffineState start{{160, 120}};

Alignment seen(double gain, double bias, double noise) {
  Alignment out;
  out.usable = true;
  out.gain = gain, out.bias = bias, out.noise = noise;
  out.zncc = 0.95, out.inliers = 0.9;
  return out;
}

TEST(Memory, TheAnchorIsTheMedianOverTheTrainingTime) {
  // A highlight covers the point in the first frame only.
  Scene scene;
  auto lit = scene.picture({});
  cv::circle(lit, {164, 120}, 3, cv::Scalar(255), cv::FILLED);
  Memory memory(scene.show(lit), start);
  const float with = memory.anchor().level(0).patch.at(4, 0);
  int frames = 0;
  for (;; ++frames) {
    const auto frame = scene.frame({});
    memory.sample_at(frame, start);
    if (memory.training_over(frame)) break;
    EXPECT_TRUE(memory.learning());
    EXPECT_EQ(memory.anchor().level(0).patch.at(4, 0), with) << "until then, the first frame's patch";
  }
  EXPECT_EQ(frames, 12) << "half a second after the first frame, at 25 frames a second";
  memory.freeze_anchor();
  EXPECT_FALSE(memory.learning());
  Scene clean;
  const Memory without(clean.frame({}), start);
  EXPECT_LT(memory.anchor().level(0).patch.at(4, 0), with - 20);
  EXPECT_NEAR(memory.anchor().level(0).patch.at(4, 0), without.anchor().level(0).patch.at(4, 0), 3);
}

TEST(Memory, LearnsTheUsualByARunningMean) {
  Scene scene;
  auto frame = scene.frame({});
  Memory memory(frame, start);
  EXPECT_EQ(memory.usual_noise(), 0);
  EXPECT_FALSE(memory.gain_change(seen(1, 0, 2)) || memory.brightness_change(seen(1, 0, 2)));
  memory.learn_usual(frame, seen(1, 100, 2));
  EXPECT_NEAR(memory.usual_noise(), 2, 1e-9) << "grey levels of the picture";
  EXPECT_NEAR(*memory.gain_change(seen(0.5, 100, 2)), std::log(0.5), 1e-12);
  EXPECT_NEAR(*memory.brightness_change(seen(1, 130, 2)), 30, 1e-12);
  EXPECT_FALSE(memory.gain_change({})) << "nothing was seen";
  memory.learn_usual(frame, seen(1, 200, 2));  // a tenth of the way in 40 ms
  EXPECT_NEAR(*memory.brightness_change(seen(1, 130, 2)), 20, 1e-9);
  frame.steps = 20;  // and all of it, after a gap
  memory.learn_usual(frame, seen(1, 130, 2));
  EXPECT_NEAR(*memory.brightness_change(seen(1, 130, 2)), 0, 1e-9);
}

TEST(Memory, TakesAFinerLevelOnceAZoomShowsIt) {
  Scene scene;
  const auto frame = scene.frame({});
  Memory memory(frame, start);
  memory.refine(frame, start, 1.5, seen(1, 0, 2));
  EXPECT_FALSE(memory.anchor().has(-1)) << ".75 of a finer sample";
  auto poor = seen(1, 0, 2);
  poor.zncc = 0.8;
  memory.refine(frame, start, 1.7, poor);
  EXPECT_FALSE(memory.anchor().has(-1)) << "badly seen";
  memory.refine(frame, start, 1.7, seen(1, 0, 2));
  EXPECT_TRUE(memory.anchor().has(-1));
  EXPECT_EQ(memory.finest_level(1.7, {}), -1);
  EXPECT_EQ(memory.finest_level(1.1, {}), 0) << "the picture shows no more";
}

TEST(Memory, MeasuresTheAnchorsDistinctnessOnce) {
  Scene scene;
  const auto frame = scene.frame({});
  Memory memory(frame, start);
  EXPECT_FALSE(memory.self_similarity());
  memory.measure_self_similarity(frame, start);
  ASSERT_TRUE(memory.self_similarity());
  const double far = memory.self_similarity()->far(), contrast = memory.contrast();
  EXPECT_LT(far, 0.8);
  EXPECT_GT(contrast, 3);
  memory.measure_self_similarity(scene.show(cv::Mat(240, 320, CV_8UC1, cv::Scalar(90))), start);
  EXPECT_EQ(memory.self_similarity()->far(), far);
  EXPECT_EQ(memory.contrast(), contrast);
}

}  // namespace
}  // namespace csd
