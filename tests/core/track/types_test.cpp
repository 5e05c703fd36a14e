// SPDX-License-Identifier: LGPL-2.1-or-later
#include "track/types.h"

#include <gtest/gtest.h>

#include "track/moving_scene.h"
#include "track/patch_side.h"

namespace csd {
namespace {

TEST(Types, HaveTheWordsOfTheSchema) {
  EXPECT_EQ(state_name(FeatureState::learning), "learning");
  EXPECT_EQ(state_name(FeatureState::tracked), "tracked");
  EXPECT_EQ(state_name(FeatureState::occluded), "occluded");
  EXPECT_EQ(state_name(FeatureState::lost), "lost");
  EXPECT_EQ(state_name(FeatureState::out), "out");
  EXPECT_EQ(state_name(FeatureState::ended), "ended");
  EXPECT_EQ(algorithm_name(AlgorithmKind::csd_2012), "csd-2012");
  EXPECT_EQ(algorithm_name(AlgorithmKind::lk), "lk");
  EXPECT_EQ(algorithm_name(AlgorithmKind::ms1), "ms1");
  EXPECT_EQ(algorithm_name(AlgorithmKind::ms2), "ms2");
  EXPECT_EQ(algorithm_name(AlgorithmKind::sift), "sift");
}

TEST(PatchSide, IsTheUsersInPixelsOfThePictureOrTheDefault) {
  const cv::Mat gray(1152, 2048, CV_8UC1, cv::Scalar(0));
  WorkFrame frame;
  frame.load(MovingScene::gray_view(gray));  // half size
  Settings settings;
  EXPECT_EQ(patch_side(settings, frame), 21);
  settings.patch_size = 62;  // 31 working pixels
  EXPECT_EQ(patch_side(settings, frame), 31);
  settings.patch_size = 1;
  EXPECT_EQ(patch_side(settings, frame), 5) << "the least that has surroundings to compare";
}

}  // namespace
}  // namespace csd
