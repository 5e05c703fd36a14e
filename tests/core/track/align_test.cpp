// SPDX-License-Identifier: LGPL-2.1-or-later
#include "track/align.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/track/warped_picture.h"

namespace csd {
namespace {

using test::render;
using test::similarity;
using test::View;
using test::Waves;

Pyramid pyramid(const cv::Mat &luma) {
  Pyramid p;
  p.build(luma);
  return p;
}

const GlareWeights no_glare;

AnchorLevel anchor(const Waves &texture, int level) {
  View first;
  first.state.position = {64, 64};
  return make_anchor_level(sample(pyramid(render(texture, first)), no_glare, first.state, level));
}

double distance(const AffineState &a, const AffineState &b) {
  return std::hypot(a.position.x - b.position.x, a.position.y - b.position.y);
}

TEST(Align, FindsPositionAndShape) {
  const Waves texture(1, 6, 25, 20);
  const AnchorLevel level0 = anchor(texture, 0);
  View view;
  view.state.position = {61.3, 66.8};
  view.state.shape = cv::Matx22d(1.04, .03, -.05, .97);
  AffineState start{{61.9, 66.1}, cv::Matx22d::eye()};
  AlignPrior vague;
  vague.shape = 1;
  for (const auto run : {align, align_scalar}) {
    const Alignment a = run(pyramid(render(texture, view)), no_glare, level0, 0, start, vague, AlignModel::affine);
    ASSERT_TRUE(a.usable);
    EXPECT_LT(distance(a.state, view.state), .02);
    EXPECT_LT(cv::norm(a.state.shape - view.state.shape), .01);
    EXPECT_GT(a.zncc, .99);
    EXPECT_NEAR(a.gain, 1, .04);
    EXPECT_GT(a.inliers, .95);
    EXPECT_DOUBLE_EQ(a.unmasked, 1);
  }
}

TEST(Align, FollowsGainBiasRotationAndScale) {
  const Waves texture(2, 6, 25, 20);
  const AnchorLevel level0 = anchor(texture, 0);
  for (const double degrees : {0., 30., 180., -75.})
    for (const double scale : {.8, 1., 1.6, 3.}) {
      View view;
      view.state = {{63.2, 65.1}, similarity(degrees, scale)};
      view.gain = .6, view.bias = 100;
      const AffineState start{view.state.position + cv::Point2d(.5, -.4) * scale,
                              similarity(degrees + 1, scale * 1.02)};
      const Alignment a = align(pyramid(render(texture, view)), no_glare, level0, 0, start, {}, AlignModel::similarity);
      ASSERT_TRUE(a.usable);
      EXPECT_LT(distance(a.state, view.state), .03 * std::max(1., scale)) << degrees << ' ' << scale;
      EXPECT_NEAR(a.state.shape(0, 0), a.state.shape(1, 1), 1e-9);
      EXPECT_NEAR(a.state.shape(0, 1), -a.state.shape(1, 0), 1e-9);
      EXPECT_GT(a.zncc, .98) << degrees << ' ' << scale;
    }
}

TEST(Align, NothingToSeeIsNotUsable) {
  const Waves texture(3, 6, 25, 20);
  const AnchorLevel level0 = anchor(texture, 0);
  const AffineState start{{64, 64}};
  const Alignment flat =
      align(pyramid(cv::Mat(128, 128, CV_8UC1, 90)), no_glare, level0, 0, start, {}, AlignModel::affine);
  EXPECT_FALSE(flat.usable);
  EXPECT_TRUE(std::isfinite(flat.state.position.x) && std::isfinite(flat.zncc));
  const Alignment outside =
      align(pyramid(render(texture, {})), no_glare, level0, 0, {{-2, 64}}, {}, AlignModel::affine);
  EXPECT_FALSE(outside.usable);
}

}  // namespace
}  // namespace csd
