// SPDX-License-Identifier: LGPL-2.1-or-later
#include "csd/self_similarity.h"

#include <gtest/gtest.h>

#include <cmath>

namespace csd {
namespace {

constexpr int width = 160, height = 120;
const cv::Point2d middle(80, 60);

/// The pyramid of a picture whose grey level at (x, y) is `grey`.
template <class Grey>
Pyramid picture(Grey grey) {
  cv::Mat luma(height, width, CV_8UC1);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) luma.at<std::uint8_t>(y, x) = cv::saturate_cast<std::uint8_t>(grey(x, y));
  Pyramid pyramid;
  pyramid.build(luma);
  return pyramid;
}

SelfSimilarity self_similarity_of(const Pyramid &pyramid) {
  const AffineState state{middle, cv::Matx22d::eye()};
  const auto anchor = make_anchor_level(sample(pyramid, {}, state, 0));
  return {pyramid, {}, anchor, 0, state, {}};
}

TEST(SelfSimilarity, AnEdgeResemblesItselfOnlyAlongItself) {
  const auto self_similarity = self_similarity_of(picture([](int x, int) { return x < 80 ? 60 : 160; }));
  EXPECT_NEAR(self_similarity.far(), 1, 1e-3);
  EXPECT_NEAR(self_similarity.near({0, 9}, 3), 1, 1e-3);
  EXPECT_NEAR(self_similarity.near({0, -9}, 3), 1, 1e-3);
  // A step of 100, shifted by 9 of 21 samples, agrees with itself in 12 of them: a poor match.
  EXPECT_LT(self_similarity.near({9, 0}, 2), 0.5);
}

TEST(SelfSimilarity, ABlobIsDistinctInAllDirections) {
  const auto self_similarity = self_similarity_of(picture([](int x, int y) {
    const double dx = x - middle.x, dy = y - middle.y;
    return 60 + 120 * std::exp(-(dx * dx + dy * dy) / 18);
  }));
  EXPECT_LT(self_similarity.far(), 0.3);
  EXPECT_LT(self_similarity.near({0, 9}, 3), 0.3);
}

TEST(SelfSimilarity, FindsTheNextPeriod) {
  // Stripes 10 px apart: the rings of 9 and 11.5 samples come within half a sample and 1.5 of a whole period.
  const auto self_similarity =
      self_similarity_of(picture([](int x, int) { return 110 + 50 * std::cos(2 * CV_PI * x / 10); }));
  EXPECT_GT(self_similarity.near({10, 0}, 3), 0.6);
  EXPECT_LT(self_similarity.near({5, 0}, 1.5), 0.1);
}

TEST(SelfSimilarity, BeyondTheRingsTheOutermostCounts) {
  const auto self_similarity = self_similarity_of(picture([](int x, int) { return x < 80 ? 60 : 160; }));
  EXPECT_EQ(self_similarity.near({0, 100}, 3), self_similarity.near({0, 14}, 3));
}

TEST(SelfSimilarity, MeasuresNothingWithinZeroReach) {
  EXPECT_EQ(self_similarity_of(picture([](int x, int) { return x < 80 ? 60 : 160; })).near({0, 0}, 1), 0);
}

}  // namespace
}  // namespace csd
