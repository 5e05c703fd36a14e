// SPDX-License-Identifier: LGPL-2.1-or-later
#include "csd2012/search.h"

#include <gtest/gtest.h>

#include <cmath>

namespace csd {
namespace {

/// A hand-made descriptor on 3×3 patches, by the middle and its left neighbour. Brighter: a feature with P = 3/4.
/// Equal: a feature with P = 1/4. Darker: no feature.
Forest by_hand() {
  std::vector<Tree::Node> nodes(4);
  nodes[0] = {4, 3, 1, 0, 0};
  nodes[1] = {0, 0, 0, 3, 1};
  nodes[2] = {0, 0, 1, 1, 0};
  nodes[3] = {0, 0, 2, 0, 5};
  return Forest({std::make_shared<const Tree>(3, ColourSpace{1, 1, 1}, nodes, 1)});
}

/// Darker from left to right, so that nothing matches, except what a test adds.
cv::Mat falling(int rows, int columns) {
  cv::Mat m(rows, columns, CV_8UC1);
  for (int x = 0; x < columns; ++x) m.col(x).setTo(250 - 3 * x);
  return m;
}

TEST(Search, FindsNothingWithoutALabelledFeature) {
  const auto result = search(by_hand(), falling(20, 30), {0, 0}, {{1, 1, 28, 18}, 1}, {{10, 10}, 5});
  EXPECT_FALSE(result.best);
  EXPECT_TRUE(result.matches.empty());
}

TEST(Search, TheLargestWeightedProbabilityWins) {
  cv::Mat m = falling(20, 30);
  m.at<unsigned char>(5, 20) = 255;                           // brighter than its left neighbour: P = 3/4
  m.at<unsigned char>(10, 11) = m.at<unsigned char>(10, 10);  // equal: P = 1/4
  const cv::Point origin(100, 200);
  const SearchArea area{{101, 201, 28, 18}, 1};
  // Distances from (111,210): 0 for the second; (120,205): √106 for the first.
  auto result = search(by_hand(), m, origin, area, {{111, 210}, 5});
  ASSERT_EQ(result.matches.size(), 2u);
  EXPECT_EQ(*result.best, cv::Point2d(111, 210));
  EXPECT_DOUBLE_EQ(result.weighted, 0.25);
  result = search(by_hand(), m, origin, area, {{111, 210}, 20});
  EXPECT_EQ(*result.best, cv::Point2d(120, 205));
  EXPECT_DOUBLE_EQ(result.weighted, 0.75 * std::exp(-106.0 / 800));
  result = search(by_hand(), m, origin, area, {{111, 210}});
  EXPECT_EQ(*result.best, cv::Point2d(120, 205));
  EXPECT_DOUBLE_EQ(result.weighted, 0.75);
}

TEST(Search, AmongEqualsTheNearestWins) {
  cv::Mat m = falling(20, 30);
  m.at<unsigned char>(5, 5) = 255;
  m.at<unsigned char>(5, 20) = 255;
  EXPECT_EQ(*search(by_hand(), m, {0, 0}, {{1, 1, 28, 18}, 1}, {{14, 5}}).best, cv::Point2d(20, 5));
  EXPECT_EQ(*search(by_hand(), m, {0, 0}, {{1, 1, 28, 18}, 1}, {{11, 5}}).best, cv::Point2d(5, 5));
}

// Steps of 2 from (1,1) visit odd positions only.
TEST(Search, VisitsEverySecondPosition) {
  cv::Mat m = falling(20, 30);
  for (int y : {6, 7}) m.at<unsigned char>(y, 9) = m.at<unsigned char>(y, 8);
  m.at<unsigned char>(6, 10) = 255;
  EXPECT_EQ(*search(by_hand(), m, {0, 0}, {{1, 1, 28, 18}, 2}, {{0, 0}}).best, cv::Point2d(9, 7));
  EXPECT_EQ(*search(by_hand(), m, {0, 0}, {{1, 1, 28, 18}, 1}, {{0, 0}}).best, cv::Point2d(10, 6));
}

// A lone patch of P = 3/4, and three adjacent ones of P = 1/4, whose sum is as large: the result is their middle.
TEST(Search, FindsTheMiddleOfACluster) {
  cv::Mat m = falling(20, 30);
  m.at<unsigned char>(5, 20) = 255;
  for (int y : {11, 12, 13, 14}) m.at<unsigned char>(y, 9) = m.at<unsigned char>(y, 8);
  const SearchArea area{{1, 1, 28, 18}, 1};
  EXPECT_EQ(*search(by_hand(), m, {0, 0}, area, {{10, 10}}).best, cv::Point2d(20, 5));
  const auto result = search(by_hand(), m, {0, 0}, area, {{10, 10}}, {2});
  ASSERT_TRUE(result.best);
  EXPECT_EQ(*result.best, cv::Point2d(9, 12.5));
  EXPECT_NEAR(result.weighted, 1, 1e-6);
  EXPECT_EQ(result.matches.size(), 5u);
}

// P = 3/4 at 10 px from the last position, σ = 10: 3/4·e^(−1/2) = .455.
TEST(Search, BelowTheLeastProbabilityItIsHidden) {
  cv::Mat m = falling(20, 30);
  m.at<unsigned char>(5, 20) = 255;
  const SearchArea area{{1, 1, 28, 18}, 1};
  const SpatialWeight weight{{10, 5}, 10};
  EXPECT_TRUE(search(by_hand(), m, {0, 0}, area, weight, {0, .45}).best);
  EXPECT_FALSE(search(by_hand(), m, {0, 0}, area, weight, {0, .46}).best);
  EXPECT_EQ(search(by_hand(), m, {0, 0}, area, weight, {0, .46}).matches.size(), 1u);
  // A cluster has the weight of its middle, which here lies towards the last position.
  EXPECT_TRUE(search(by_hand(), m, {0, 0}, area, weight, {2, .54}).best) << "3/4·e^(−.32) = .545";
  EXPECT_FALSE(search(by_hand(), m, {0, 0}, area, weight, {2, .55}).best);
}

// σ = width/128. Absence widens it by √(1 + absence/40 ms), and the window to at most twice its size.
TEST(Search, TheReachGrowsWithTheAbsence) {
  constexpr std::int64_t ms = 1000000;
  EXPECT_DOUBLE_EQ(reach_after(csd2012::Choices{}, 0, 640, 20).sigma, 5);
  EXPECT_EQ(reach_after(csd2012::Choices{}, 0, 640, 20).radius, 20);
  EXPECT_NEAR(reach_after(csd2012::Choices{}, 40 * ms, 640, 20).sigma, 7.0711, 1e-4);
  EXPECT_EQ(reach_after(csd2012::Choices{}, 40 * ms, 640, 20).radius, 28);
  EXPECT_DOUBLE_EQ(reach_after(csd2012::Choices{}, 120 * ms, 640, 20).sigma, 10);
  EXPECT_EQ(reach_after(csd2012::Choices{}, 120 * ms, 640, 20).radius, 40);
  EXPECT_DOUBLE_EQ(reach_after(csd2012::Choices{}, 960 * ms, 640, 20).sigma, 25);
  EXPECT_EQ(reach_after(csd2012::Choices{}, 960 * ms, 640, 20).radius, 40);
}

TEST(Search, FindsNothingInAnEmptyArea) {
  EXPECT_FALSE(search(by_hand(), falling(20, 30), {0, 0}, {{}, 1}, {{0, 0}}).best);
}

}  // namespace
}  // namespace csd
