// SPDX-License-Identifier: LGPL-2.1-or-later
#include "track/centre.h"

#include <gtest/gtest.h>

#include <opencv2/imgproc.hpp>

#include "track/moving_scene.h"

namespace csd {
namespace {

class Centre : public testing::Test {
 protected:
  void SetUp() override {
    cv::cvtColor(MovingScene().render({}), luma_, cv::COLOR_BGR2GRAY);
    pyramid_.build(luma_);
    anchor_ = make_anchor_level(sample(pyramid_, glare_, {at_}, 0));
  }
  double of(cv::Rect covered) {
    luma_(covered).setTo(250);
    pyramid_.build(luma_);
    const auto seen = align(pyramid_, glare_, anchor_, 0, {at_}, {}, AlignModel::affine);
    EXPECT_TRUE(seen.usable);
    auto there = seen;
    there.state.position = at_;
    there.gain = 1;
    there.bias = bias_;
    return centre_inliers(pyramid_, glare_, anchor_, 0, there, 1);
  }
  const cv::Point2d at_{160, 120};
  cv::Mat luma_;
  Pyramid pyramid_;
  GlareWeights glare_;  // empty: no highlights
  AnchorLevel anchor_;
  double bias_ = 0;
};

TEST_F(Centre, IsOneWhereAllFits) {
  auto seen = align(pyramid_, glare_, anchor_, 0, {at_}, {}, AlignModel::affine);
  ASSERT_TRUE(seen.usable);
  EXPECT_GT(centre_inliers(pyramid_, glare_, anchor_, 0, seen, 1), 0.98);
  bias_ = seen.bias;
  // What covers a corner of the patch leaves the centre alone.
  EXPECT_GT(of({164, 124, 10, 10}), 0.85);
}

TEST_F(Centre, IsLowWhereThePointItselfIsCovered) {
  const auto seen = align(pyramid_, glare_, anchor_, 0, {at_}, {}, AlignModel::affine);
  bias_ = seen.bias;
  EXPECT_LT(of({155, 115, 11, 11}), 0.1);
}

TEST_F(Centre, HalfCoveredIsAboutAHalf) {
  const auto seen = align(pyramid_, glare_, anchor_, 0, {at_}, {}, AlignModel::affine);
  bias_ = seen.bias;
  const double half = of({161, 105, 12, 30});  // 3 of 7 columns, and the blur of the pyramid
  EXPECT_GT(half, 0.2);
  EXPECT_LT(half, 0.7);
}

}  // namespace
}  // namespace csd
