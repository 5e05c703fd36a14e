// SPDX-License-Identifier: LGPL-2.1-or-later
#include "track/patch_side.h"

#include <gtest/gtest.h>

#include "track/moving_scene.h"

namespace csd {
namespace {

TEST(PatchSide, IsTheUsersInPixelsOfThePictureElseTheDefault) {
  const cv::Mat gray(1152, 2048, CV_8UC1, cv::Scalar(0));
  WorkFrame frame;
  frame.load(MovingScene::gray_view(gray));  // half size
  Settings settings;
  EXPECT_EQ(patch_side(settings, frame), 21);
  settings.patch_size = 62;  // 31 working pixels
  EXPECT_EQ(patch_side(settings, frame), 31);
  settings.patch_size = 1;
  EXPECT_EQ(patch_side(settings, frame), 5) << "the smallest with surroundings to compare";
}

}  // namespace
}  // namespace csd
