// SPDX-License-Identifier: LGPL-2.1-or-later
#include "csd/similarity.h"

#include <gtest/gtest.h>

#include <array>

namespace csd {
namespace {

// A quarter turn, twice as large, shifted by (3, −1): (x, y) → (3 − 2y, 2x − 1).
cv::Point2d quarter_turn(cv::Point2d p) {
  return {3 - 2 * p.y, 2 * p.x - 1};
}

void expect_quarter_turn(const Similarity &s) {
  EXPECT_NEAR(s.a, 0, 1e-12);
  EXPECT_NEAR(s.b, 2, 1e-12);
  EXPECT_NEAR(s.shift.x, 3, 1e-12);
  EXPECT_NEAR(s.shift.y, -1, 1e-12);
  EXPECT_NEAR(s.scale(), 2, 1e-12);
}

TEST(Similarity, GoesThroughTwoPoints) {
  const cv::Point2d p(1, 2), q(5, -3);
  expect_quarter_turn(similarity_through({p, quarter_turn(p)}, {q, quarter_turn(q)}));
}

TEST(Similarity, IsFittedToWeightedPoints) {
  const std::array<cv::Point2d, 4> places{{{0, 0}, {4, 1}, {-2, 5}, {7, 7}}};
  std::array<Correspondence, 4> points;
  for (std::size_t i = 0; i < places.size(); ++i) points[i] = {places[i], quarter_turn(places[i])};
  points[3].to = {100, 100};  // without weight
  const std::array<double, 4> weights{1, 0.5, 3, 0};
  expect_quarter_turn(fit_similarity(PointMoments::of(points, weights.data())));
}

TEST(Similarity, OfTwoOpposedErrorsIsTheirMean) {
  // Two opposite corners of a square move outwards and two inwards by as much: the best similarity is the identity.
  const std::array<Correspondence, 4> points{
      {{{1, 1}, {1.2, 1.2}}, {{-1, -1}, {-1.2, -1.2}}, {{1, -1}, {0.8, -0.8}}, {{-1, 1}, {-0.8, 0.8}}}};
  const std::array<double, 4> weights{1, 1, 1, 1};
  const auto s = fit_similarity(PointMoments::of(points, weights.data()));
  EXPECT_NEAR(s.a, 1, 1e-12);
  EXPECT_NEAR(s.b, 0, 1e-12);
}

TEST(Similarity, PointsThatCoincideAreDegenerate) {
  const std::array<Correspondence, 2> points{{{{2, 2}, {5, 5}}, {{2, 2}, {7, 7}}}};
  const std::array<double, 2> weights{1, 1};
  EXPECT_TRUE(PointMoments::of(points, weights.data()).degenerate());
}

TEST(Similarity, KnowsHowFarItZooms) {
  EXPECT_TRUE((Similarity{0, 4, {}}.zooms_at_most(4)));
  EXPECT_FALSE((Similarity{0, 4.1, {}}.zooms_at_most(4)));
  EXPECT_TRUE((Similarity{0.25, 0, {}}.zooms_at_most(4)));
  EXPECT_FALSE((Similarity{0.24, 0, {}}.zooms_at_most(4)));
}

}  // namespace
}  // namespace csd
