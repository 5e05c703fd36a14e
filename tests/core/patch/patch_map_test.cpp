// SPDX-License-Identifier: LGPL-2.1-or-later
#include "patch/patch_map.h"

#include <gtest/gtest.h>

#include "core/patch/warped_picture.h"

namespace csd {
namespace {

using test::similarity;

TEST(PatchMap, TakesTheLevelNearestInSize) {
  const auto at = [](double scale, int level) { return matching_level({{}, similarity(50, scale)}, level); };
  EXPECT_EQ(at(1, 0), 0);
  EXPECT_EQ(at(1, 2), 2);
  EXPECT_EQ(at(1.40, 0), 0);
  EXPECT_EQ(at(1.42, 0), 1);
  EXPECT_EQ(at(.3, 0), 0);
  EXPECT_EQ(at(100, 2), 4);
}

TEST(PatchMap, IsTheStateInTheLevelsPixels) {
  const PatchMap map = patch_map({{80, 48}, {0, -2, 2, 0}}, 1, 3);
  EXPECT_EQ(map.origin, cv::Point2d(10, 6));
  EXPECT_EQ(map.step, cv::Matx22d(0, -.5, .5, 0));  // 2 · 2¹ / 2³
  EXPECT_EQ(patch_map({{80, 48}}, -2, 0).step, cv::Matx22d(.25, 0, 0, .25));
}

}  // namespace
}  // namespace csd
