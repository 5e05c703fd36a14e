// SPDX-License-Identifier: LGPL-2.1-or-later
#include "baselines/colour_weights.h"

#include <gtest/gtest.h>

#include <cmath>

namespace csd {
namespace {

TEST(ColourWeights, CountsOnlyPixelsInside) {
  cv::Mat values(2, 5, CV_8UC1, cv::Scalar(7));  // bin 0
  values.at<std::uint8_t>(0, 4) = 8;             // bin 1
  values.at<std::uint8_t>(1, 1) = 255;           // bin 31
  const auto all = count_colours(values, {-3, -3, 20, 20});
  EXPECT_EQ(all[0], 8u);
  EXPECT_EQ(all[1], 1u);
  EXPECT_EQ(all[31], 1u);
  EXPECT_EQ(total(all), 10u);
  const auto part = count_colours(values, {1, 0, 3, 2});
  EXPECT_EQ(part[0], 5u);
  EXPECT_EQ(part[31], 1u);
  const auto rest = difference(all, part);
  EXPECT_EQ(rest[0], 3u);
  EXPECT_EQ(rest[1], 1u);
  EXPECT_EQ(rest[31], 0u);
  EXPECT_EQ(sum(rest, part), all);
  EXPECT_EQ(total(count_colours(values, {9, 9, 3, 3})), 0u);
}

TEST(ColourWeights, AreTheLogLikelihoodRatioWhereItIsPositive) {
  ColourHistogram object{}, background{};
  object[0] = 3, object[1] = 1;
  background[0] = 2, background[1] = 6, background[7] = 8;
  object[9] = 4;
  const auto w = likelihood_weights(object, background, LogTable(16));
  // L = ln(p/q): bin 0: p = 3/8, q = 2/16: ln 3 = 1.0986; · 32 = 35.16
  EXPECT_EQ(w[0], 35);
  EXPECT_EQ(w[7], 35);  // the same bin
  EXPECT_EQ(w[8], 0);   // p = 1/8 < q = 6/16
  EXPECT_EQ(w[56], 0);  // not in the object
  // Not in the background: ln((1/2)/0.001) = 6.2146; · 32 = 198.87
  EXPECT_EQ(w[72], 199);
  EXPECT_EQ(w[255], 0);  // in neither: both are δ
}

TEST(ColourWeights, AreZeroWithoutPixels) {
  ColourHistogram some{};
  some[3] = 5;
  for (const auto w : likelihood_weights(some, {}, LogTable(8))) EXPECT_EQ(w, 0);
  for (const auto w : likelihood_weights({}, some, LogTable(8))) EXPECT_EQ(w, 0);
}

TEST(ColourWeights, VarianceRatioOfTwoHistogramsByHand) {
  // p = (1/2, 1/2), q = (1/4, 3/4): L = (ln 2, ln 2/3) = (.693147, -.405465).
  // p: mean .143841, mean square .322427, variance .301737; q: -.130812, .243415, .226303; both: .006514, .282921,
  // .282879. V = .282879 / (.301737 + .226303) = .535715.
  ColourHistogram p{}, q{};
  p[4] = 8, p[5] = 8;
  q[4] = 4, q[5] = 12;
  EXPECT_NEAR(variance_ratio(p, 16, q, 16, LogTable(16)), 0.535715, 1e-5);
  EXPECT_EQ(variance_ratio(p, 16, p, 16, LogTable(16)), 0);
}

/// A 21 × 21 picture with blobs of 3 × 3 pixels in the object's colour.
cv::Mat blobs(std::initializer_list<cv::Point> centres) {
  cv::Mat values(21, 21, CV_8UC1, cv::Scalar(0));
  for (const auto c : centres) values(cv::Rect(c.x - 1, c.y - 1, 3, 3) & cv::Rect(0, 0, 21, 21)).setTo(8);
  return values;
}

double difference_of(const cv::Mat &values) {
  ColourWeights weights{};
  weights[8] = 64;  // L = 2
  return peak_difference(values, weights, {9, 9, 3, 3}, {3, 3, 15, 15}, 3);
}

TEST(PeakDifference, IsTheDifferenceOfWindowSums) {
  // In the object, all 9 pixels of a window have L = 2. Two columns beside it, 3 of them have.
  EXPECT_DOUBLE_EQ(difference_of(blobs({{10, 10}})), 2 - 2 * 3 / 9.0);
}

TEST(PeakDifference, VanishesBesideAnEqualBlob) {
  EXPECT_DOUBLE_EQ(difference_of(blobs({{10, 10}, {15, 10}})), 0);
  EXPECT_DOUBLE_EQ(difference_of(blobs({{10, 10}, {10, 4}})), 0);
}

TEST(PeakDifference, LooksNoFurtherThanTheNeighbourhood) {
  // Window centres go up to 17. Such a window holds one column of a blob at 19, as one beside the object does.
  EXPECT_DOUBLE_EQ(difference_of(blobs({{10, 10}, {19, 10}})), 2 - 2 * 3 / 9.0);
}

TEST(PeakDifference, IsNegativeWhereOnlyADistractorExists) {
  EXPECT_DOUBLE_EQ(difference_of(blobs({{15, 10}})), -2);
}

}  // namespace
}  // namespace csd
