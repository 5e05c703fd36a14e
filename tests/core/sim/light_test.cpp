// SPDX-License-Identifier: LGPL-2.1-or-later
#include "sim/light.h"

#include <gtest/gtest.h>

#include <algorithm>

namespace csd::sim {
namespace {

const cv::Size vga{640, 480};

Light at(double time, const std::string &effects) {
  Effects e;
  e.set(effects);
  return Light(time, e, 1, camera_at(time, e, 1, vga));
}

const cv::Vec3d up{0, 0, 1}, tilted{0.6, 0, 0.8};

TEST(Light, WithoutEffectsBelongsToTheTissue) {
  const double lit = at(0, "").on(up, up, {0, 0, 0});
  EXPECT_DOUBLE_EQ(lit, 1);
  // The surface's motion doesn't matter, only its form at rest.
  EXPECT_EQ(at(7, "").on(up, tilted, {30, 50, 60}), lit);
  EXPECT_LT(at(0, "").on(tilted, up, {0, 0, 0}), 0.75 * lit);
  EXPECT_EQ(at(7, "").gain(), cv::Vec3d(1, 1, 1));
}

TEST(Light, FollowsTheSurface) {
  const Light light = at(0, "light");
  EXPECT_LT(light.on(up, tilted, {0, 0, 0}), 0.8 * light.on(up, up, {0, 0, 0}));
  double least = 9, most = 0;
  for (double t = 0; t < 30; t += 0.2) {
    least = std::min(least, at(t, "light").gain()[1]);
    most = std::max(most, at(t, "light").gain()[1]);
  }
  EXPECT_LT(least, 0.9);
  EXPECT_GT(most, 1.1);
  EXPECT_EQ(at(0, "light").gain(), cv::Vec3d(1, 1, 1));
}

TEST(Light, FallsOffWithDistance) {
  const Light light = at(0, "falloff");
  const double here = light.on(up, up, {0, 0, 0}), nearer = light.on(up, up, {0, 0, 30});
  EXPECT_NEAR(here, 1, 0.01);
  EXPECT_GT(nearer, 1.1 * here);
  EXPECT_LT(light.on(up, up, {0, 0, -30}), 0.92 * here);
  EXPECT_GT(at(0, "falloff=2").on(up, up, {0, 0, 30}), nearer);
}

TEST(Light, LeavesHalfForTheFarEndOfACavity) {
  const Light light = at(0, "cavity");
  const double near = light.on(up, up, {100, 0, 250}), far = light.on(up, up, {0, 0, -700});
  EXPECT_LT(far, 0.65 * near);
  EXPECT_GT(far, 0.4 * near);
}

TEST(Light, ExposureJumps) {
  double quickest = 0;
  for (double t = 0; t < 30; t += 0.04) {
    quickest = std::max(quickest, std::abs(at(t + 0.04, "exposure").gain()[0] / at(t, "exposure").gain()[0] - 1));
    EXPECT_EQ(at(t, "exposure").gain()[0], at(t, "exposure").gain()[2]);
  }
  EXPECT_GT(quickest, 0.05);
  EXPECT_LT(quickest, 0.5);
  EXPECT_EQ(at(0, "exposure").gain()[0], 1);
}

TEST(Vignette, DarkensTheCorners) {
  EXPECT_NEAR(vignette(319.5F, 239.5F, vga, 1), 1, 1e-6);
  EXPECT_NEAR(vignette(0, 0, vga, 1), 0.55, 0.01);
  EXPECT_EQ(vignette(0, 0, vga, 0), 1);
  EXPECT_FLOAT_EQ(vignette(10, 20, vga, 1), vignette(629, 459, vga, 1));
  EXPECT_GE(vignette(0, 0, vga, 4), 0);
}

}  // namespace
}  // namespace csd::sim
