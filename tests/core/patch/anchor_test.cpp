// SPDX-License-Identifier: LGPL-2.1-or-later
#include "patch/anchor.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "core/patch/patch_offsets.h"
#include "core/patch/warped_picture.h"
#include "core/track/moving_scene.h"
#include "image/work_frame.h"

namespace csd {
namespace {

using test::for_each_offset;
using test::similarity;

constexpr int radius = PatchPlane::radius;
const GlareWeights no_glare;

/// A picture whose grey level is a plane: neither the pyramid's smoothing nor bilinear sampling changes it.
cv::Mat plane(cv::Size size, double x, double y, double constant) {
  cv::Mat m(size, CV_8UC1);
  for (int j = 0; j < m.rows; ++j)
    for (int i = 0; i < m.cols; ++i) m.ptr(j)[i] = cv::saturate_cast<std::uint8_t>(x * i + y * j + constant);
  return m;
}

Pyramid pyramid(const cv::Mat &luma) {
  Pyramid p;
  p.build(luma);
  return p;
}

TEST(Anchor, KnowsItsLevels) {
  Anchor a;
  a.set(1, {});
  EXPECT_EQ(a.fine_level(1), 1);
  EXPECT_EQ(a.fine_level(.1), 1);  // too small for any of its levels: the coarsest
  a.set(2, {});
  a.set(0, {});
  EXPECT_TRUE(a.has(0) && a.has(1) && a.has(2));
  EXPECT_FALSE(a.has(-1) || a.has(-2) || a.has(-3) || a.has(3));
  EXPECT_EQ(a.fine_level(.75), 0);
  EXPECT_EQ(a.fine_level(.74), 1);
  EXPECT_EQ(a.fine_level(.37), 2);
  EXPECT_EQ(a.fine_level(.1), 2);
  EXPECT_EQ(a.fine_level(3), 0);  // −1 would do, but doesn't exist
  a.set(-2, {});
  EXPECT_EQ(a.fine_level(2.9), 0);
  EXPECT_EQ(a.fine_level(3), -2);  // the finest, also beyond a gap
}

TEST(Sample, ReadsThroughTheState) {
  // 1 and 2 grey levels a pixel: integers at all pixels.
  const Pyramid p = pyramid(plane({100, 60}, 1, 2, 10));
  for (const int level : {0, 1}) {
    const AffineState state{{50.25, 30.75}, similarity(30, .7)};
    const PatchSample s = sample(p, no_glare, state, level);
    EXPECT_EQ(s.inside, 1);
    for_each_offset([&](int x, int y) {
      const cv::Vec2d u = state.shape * cv::Vec2d(x, y) * (1 << level);
      EXPECT_NEAR(s.value.at(x, y), 50.25 + u[0] + 2 * (30.75 + u[1]) + 10, .02) << x << ' ' << y;
      EXPECT_EQ(s.weight.at(x, y), 1);
    });
  }
}

TEST(Sample, OutsideThePictureWeighsNothing) {
  const Pyramid p = pyramid(plane({100, 60}, 1, 2, 10));
  const PatchSample s = sample(p, no_glare, {{3, 57}}, 0);
  for_each_offset([&](int x, int y) {
    const bool in = x >= -3 && y <= 2;
    EXPECT_EQ(s.weight.at(x, y), in ? 1 : 0) << x << ' ' << y;
    EXPECT_TRUE(std::isfinite(s.value.at(x, y)));
  });
  EXPECT_DOUBLE_EQ(s.inside, 14. * 13 / 441);
  const PatchSample far = sample(p, no_glare, {{-500, 9000}}, 0);
  EXPECT_EQ(far.inside, 0);
}

TEST(Sample, AcceptsLargePatches) {
  // Above the coarsest level, a patch spans more than any tile.
  const Pyramid p = pyramid(cv::Mat(900, 1600, CV_8UC1, 77));
  const PatchSample s = sample(p, no_glare, {{800, 450}, cv::Matx22d::eye() * 20}, 2);
  EXPECT_EQ(s.inside, 11. * 20 / 441);  // at level 4, 100 × 57 pixels, samples are 5 apart
  EXPECT_NEAR(s.value.at(3, 3), 77, 1e-3);
}

TEST(Sample, HighlightsWeighNothing) {
  const cv::Mat luma(80, 100, CV_8UC1, 100);
  WorkFrame frame;
  frame.load(MovingScene::gray_view(luma));
  cv::Mat forbidden = cv::Mat::zeros(luma.size(), CV_8UC1);
  forbidden.colRange(53, 100).setTo(255);
  GlareWeights glare;
  glare.build(frame, forbidden);
  const PatchSample s = sample(pyramid(luma), glare, {{50.5, 40}}, 0);
  EXPECT_EQ(s.inside, 1);
  for_each_offset([&](int x, int y) {
    EXPECT_NEAR(s.weight.at(x, y), x < 2 ? 1 : x == 2 ? .5 : x == 1 ? 1 : 0, x <= 2 ? .51 : 0) << x << ' ' << y;
  });
  EXPECT_EQ(s.weight.at(-5, 0), 1);
  EXPECT_EQ(s.weight.at(3, 0), 0);
}

/// What two pictures show at a sample, as values of GlareWeights / 255, and the weight of their comparison.
TEST(WeighAgreement, WhatIsBrightInBothIsTextureAndInOneAHighlight) {
  constexpr float tissue = 1, bright = GlareWeights::highlight / 255.F, nothing = 0, half = (tissue + bright) / 2;
  const struct {
    float anchor, picture, weight, tissue;
  } cases[] = {{tissue, tissue, 1, 1},      {bright, bright, 1, 0},  {tissue, bright, 0, 0},  {bright, tissue, 0, 0},
               {tissue, half, .5F, .5F},    {half, half, 1, .25F},   {half, bright, .5F, 0},  {nothing, tissue, 0, 0},
               {tissue, nothing, 0, 0},     {nothing, bright, 0, 0}, {bright, nothing, 0, 0}, {nothing, nothing, 0, 0},
               {bright, bright / 2, .5F, 0}};
  for (const auto &c : cases) {
    SCOPED_TRACE(testing::Message() << c.anchor << ' ' << c.picture);
    PatchSample first;
    for_each_offset([&](int x, int y) { first.weight.at(x, y) = c.anchor; });
    PatchPlane weight, of_tissue;
    weight.data.fill(c.picture);
    weigh_agreement(make_anchor_level(first), weight, of_tissue);
    for_each_offset([&](int x, int y) {
      ASSERT_FLOAT_EQ(weight.at(x, y), c.weight);
      ASSERT_FLOAT_EQ(of_tissue.at(x, y), c.tissue);
    });
    // The padding shows nothing.
    for (int x = radius + 1; x < PatchPlane::stride - radius; ++x) EXPECT_EQ(weight.at(x, 0), 0);
    for (int x = -radius; x <= radius; ++x) EXPECT_EQ(weight.at(x, radius + 1), 0);
  }
}

TEST(AnchorLevel, RemovesTheMeanAndHasCentralGradients) {
  PatchSample s;
  for_each_offset([&](int x, int y) {
    s.value.at(x, y) = static_cast<float>(x * x + 3 * y + 50);
    s.weight.at(x, y) = x >= 0 ? 1 : 0;
  });
  const AnchorLevel a = make_anchor_level(s);
  // Mean over x = 0…10: 385 / 11 = 35.
  for_each_offset([&](int x, int y) {
    EXPECT_NEAR(a.patch.at(x, y), x * x + 3 * y - 35, 1e-4);
    EXPECT_NEAR(a.gradient_x.at(x, y), std::abs(x) < radius ? 2 * x : x > 0 ? 19 : -19, 1e-4);
    EXPECT_NEAR(a.gradient_y.at(x, y), 3, 1e-4);
    EXPECT_EQ(a.weight.at(x, y), s.weight.at(x, y));
  });
  for (std::size_t i = 0; i < PatchPlane::size; ++i)
    if (i % PatchPlane::stride >= PatchPlane::side) {
      EXPECT_EQ(a.weight.data[i], 0);
    }
}

TEST(AnchorLevel, KnowsWhichSharesShowTissueAndAnything) {
  PatchSample s;
  // Of 21 columns ten show tissue, five a highlight, six nothing.
  for_each_offset([&](int x, int y) {
    s.weight.at(x, y) = x < 0 ? 1.F : x < 5 ? GlareWeights::highlight / 255.F : 0.F;
  });
  const AnchorLevel a = make_anchor_level(s);
  EXPECT_NEAR(a.tissue_share, 10 / 21., 1e-6);
  EXPECT_NEAR(a.shown_share, 15 / 21., 1e-6);
}

}  // namespace
}  // namespace csd
