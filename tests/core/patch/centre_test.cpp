// SPDX-License-Identifier: LGPL-2.1-or-later
#include "patch/centre.h"

#include <gtest/gtest.h>

#include <opencv2/imgproc.hpp>

#include "patch/align.h"
#include "track/moving_scene.h"

namespace csd {
namespace {

class Centre : public testing::Test {
 protected:
  void SetUp() override {
    cv::cvtColor(MovingScene().render({}), luma_, cv::COLOR_BGR2GRAY);
    pyramid_.build(luma_);
    anchor_ = make_anchor_level(sample(pyramid_, glare_, {at_}, 0));
    const auto seen = align(pyramid_, glare_, anchor_, 0, {at_}, {}, AlignModel::affine);
    ASSERT_TRUE(seen.usable);
    bias_ = seen.bias;
  }
  /// The picture at the anchor's own place, weighed by their agreement.
  PatchSample agreeing() const {
    auto seen = sample(pyramid_, glare_, {at_}, 0);
    PatchPlane tissue;
    weigh_agreement(anchor_, seen.weight, tissue);
    return seen;
  }
  /// At the anchor's own place, in a picture with an area `covered`.
  double of(cv::Rect covered) {
    luma_(covered).setTo(250);
    pyramid_.build(luma_);
    const auto seen = agreeing();
    return centre_inliers(anchor_, seen.value, seen.weight, 1, bias_, 1).value();
  }
  const cv::Point2d at_{160, 120};
  cv::Mat luma_;
  Pyramid pyramid_;
  GlareWeights glare_;  // empty: no highlights
  AnchorLevel anchor_;
  double bias_ = 0;
};

TEST_F(Centre, IsOneWhereEverythingFits) {
  EXPECT_GT(of({0, 0, 1, 1}), 0.98);
  // A covered corner of the patch leaves the centre alone.
  EXPECT_GT(of({164, 124, 10, 10}), 0.85);
}

TEST_F(Centre, IsLowWhereThePointItselfIsCovered) {
  EXPECT_LT(of({155, 115, 11, 11}), 0.1);
}

TEST_F(Centre, IsAboutAHalfWhereHalfIsCovered) {
  const double half = of({161, 105, 12, 30});  // 3 of 7 columns, and the pyramid's blur
  EXPECT_GT(half, 0.2);
  EXPECT_LT(half, 0.7);
}

TEST_F(Centre, AllowsForGainBiasAndNoise) {
  const auto seen = sample(pyramid_, glare_, {at_}, 0);
  auto brighter = seen.value;
  for (auto &x : brighter.data) x = 2 * x + 30;
  EXPECT_GT(centre_inliers(anchor_, brighter, seen.weight, 2, 2 * bias_ + 30, 1).value(), 0.98);
  EXPECT_LT(centre_inliers(anchor_, brighter, seen.weight, 1, bias_, 1).value(), 0.1);
  // Usual noise is no misfit: 12 grey levels are two deviations of 6, and 1 + (12 / 18)² squared is 2.09.
  auto off = seen.value;
  for (auto &x : off.data) x += 12;
  EXPECT_NEAR(centre_inliers(anchor_, off, seen.weight, 1, bias_, 6).value(), 1 / 2.09, 0.05);
}

TEST_F(Centre, IsPartOfAnAlignment) {
  const auto centre_of = [&](double usual_noise) {
    AlignPrior prior;
    prior.noise = usual_noise;
    const auto seen = align(pyramid_, glare_, anchor_, 0, {at_}, prior, AlignModel::affine);
    EXPECT_TRUE(seen.usable);
    return seen.centre;
  };
  EXPECT_GT(centre_of(0), 0.98);
  luma_({157, 117, 7, 7}) += 15;  // half of it would be usual with noise of 15 grey levels
  pyramid_.build(luma_);
  EXPECT_GT(centre_of(15), centre_of(0) + 0.2);
  const auto inliers = [&] { return align(pyramid_, glare_, anchor_, 0, {at_}, {}, AlignModel::affine); };
  for (int v = -3; v <= 3; ++v)
    for (int u = -3; u <= 3; ++u) anchor_.weight.at(u, v) = 0;
  EXPECT_EQ(inliers().centre, inliers().inliers) << "the anchor's middle is masked";
}

TEST_F(Centre, IsUnknownWhereTheAnchorIsMasked) {
  const auto known = [&] {
    const auto seen = agreeing();
    return centre_inliers(anchor_, seen.value, seen.weight, 1, bias_, 1).has_value();
  };
  for (int v = -3; v <= 3; ++v)
    for (int u = -3; u <= 1; ++u) anchor_.weight.at(u, v) = 0;  // 35 of 49
  EXPECT_FALSE(known());
  for (int v = -3; v <= 3; ++v) anchor_.weight.at(1, v) = 1;
  EXPECT_TRUE(known());
}

TEST_F(Centre, WhatPictureAndAnchorMaskIsTexture) {
  for (float &w : anchor_.weight.data) w = 0;
  auto seen = sample(pyramid_, glare_, {at_}, 0);
  for (float &w : seen.weight.data) w *= .5F;
  PatchPlane tissue;
  weigh_agreement(anchor_, seen.weight, tissue);
  EXPECT_GT(centre_inliers(anchor_, seen.value, seen.weight, 1, bias_, 1).value(), 0.98);
}

}  // namespace
}  // namespace csd
