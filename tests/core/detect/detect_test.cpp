// SPDX-License-Identifier: LGPL-2.1-or-later
#include "detect/detect.h"

#include <gtest/gtest.h>

#include <opencv2/imgproc.hpp>

#include <cmath>

#include "detect/merge.h"

namespace {

cv::Mat noise(int rows, int cols) {
  cv::Mat result(rows, cols, CV_8UC1);
  cv::RNG rng(3);
  rng.fill(result, cv::RNG::UNIFORM, 60, 200);
  cv::GaussianBlur(result, result, {}, 2);
  return result;
}

TEST(Detect, NothingWhereNothingIs) {
  for (const int grey : {0, 16, 128, 255}) {
    EXPECT_TRUE(csd::detect(cv::Mat(480, 640, CV_8UC1, cv::Scalar(grey)), {}, {}, {}).empty());
  }
  for (const int side : {1, 2, 8, 20}) EXPECT_TRUE(csd::detect(noise(side, side), {}, {}, {}).empty());
  EXPECT_TRUE(csd::detect({}, {}, {}, {}).empty());
}

TEST(Detect, PatchesLieInsideApartAndAllowed) {
  const cv::Mat luma = noise(240, 320);
  cv::Mat specular = cv::Mat::zeros(luma.size(), CV_8UC1), forbidden = specular.clone();
  specular(cv::Rect(200, 100, 40, 40)).setTo(255);
  forbidden.colRange(0, 100).setTo(255);
  const auto found = csd::detect(luma, specular, forbidden, {21, 50});
  ASSERT_EQ(found.size(), 50U);
  for (std::size_t i = 0; i < found.size(); ++i) {
    const cv::Point2d p = found[i];
    EXPECT_GE(p.x, 99.5);
    EXPECT_LE(p.x, 319.5 - 10);
    EXPECT_GE(p.y, 9.5);
    EXPECT_LE(p.y, 239.5 - 10);
    const cv::Rect patch(cvRound(p.x) - 10, cvRound(p.y) - 10, 21, 21);
    EXPECT_LE(cv::countNonZero(specular(patch)), 0.05 * 21 * 21 + 1e-9);
    for (std::size_t j = 0; j < i; ++j) EXPECT_GE(cv::norm(p - found[j]), 10.5);
  }
  EXPECT_EQ(found, csd::detect(luma, specular, forbidden, {21, 50}));
}

TEST(Merge, AlternatesByRankAndDropsNeighbours) {
  const csd::Candidates a{{{0, 0}, 9}, {{50, 0}, 8}}, b{{{3, 0}, 1}, {{20, 0}, 0.5F}, {{80, 0}, 0.1F}};
  const std::vector<cv::Point2d> expected{{0, 0}, {50, 0}, {20, 0}};
  const std::vector<cv::Point2d> taken{{82, 0}};
  EXPECT_EQ(csd::merge_by_rank(a, b, 5, taken), expected);
}

TEST(Merge, SpreadTakesTheBestOfEachBucketFirst) {
  const std::vector<cv::Point2d> ranked{{1, 1}, {2, 2}, {3, 3}, {15, 1}, {1, 15}};
  EXPECT_EQ(csd::spread(ranked, {20, 20}, 10, 3), (std::vector<cv::Point2d>{{1, 1}, {15, 1}, {1, 15}}));
  const std::vector<cv::Point2d> taken{{16, 2}};
  EXPECT_EQ(csd::spread(ranked, {20, 20}, 10, 2, taken), (std::vector<cv::Point2d>{{1, 1}, {1, 15}}));
}

}  // namespace
