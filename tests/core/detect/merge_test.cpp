// SPDX-License-Identifier: LGPL-2.1-or-later
#include "detect/merge.h"

#include <gtest/gtest.h>

namespace {

TEST(Merge, AlternatesByRankAndDropsNeighbours) {
  const csd::Candidates a{{{0, 0}, 9}, {{50, 0}, 8}}, b{{{3, 0}, 1}, {{20, 0}, 0.5F}, {{80, 0}, 0.1F}};
  const std::vector<cv::Point2d> expected{{0, 0}, {50, 0}, {20, 0}};
  const std::vector<cv::Point2d> taken{{82, 0}};
  EXPECT_EQ(csd::merge_by_rank(a, b, 5, taken), expected);
}

// A cell index that exceeds int is undefined behaviour; a sanitizer reports it.
TEST(Merge, AcceptsTakenPointsBeyondAnyPicture) {
  const std::vector<cv::Point2d> taken = {{4e307, -4e307}, {-1e12, 3}};
  EXPECT_EQ(csd::merge_by_rank({{{3, 3}, 1}}, {}, 5, taken).size(), 1u);
  EXPECT_EQ(csd::spread({{3, 3}}, {64, 48}, 8, 5, taken).size(), 1u);
}

TEST(Merge, SpreadTakesTheBestOfEachBucketFirst) {
  const std::vector<cv::Point2d> ranked{{1, 1}, {2, 2}, {3, 3}, {15, 1}, {1, 15}};
  EXPECT_EQ(csd::spread(ranked, {20, 20}, 10, 3), (std::vector<cv::Point2d>{{1, 1}, {15, 1}, {1, 15}}));
  const std::vector<cv::Point2d> taken{{16, 2}};
  EXPECT_EQ(csd::spread(ranked, {20, 20}, 10, 2, taken), (std::vector<cv::Point2d>{{1, 1}, {1, 15}}));
}

}  // namespace
