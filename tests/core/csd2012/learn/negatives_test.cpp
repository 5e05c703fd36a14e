// SPDX-License-Identifier: LGPL-2.1-or-later
#include "csd2012/learn/negatives.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

namespace csd {
namespace {

constexpr NegativeRules rules{.patch = 21, .ignore_radius = 4, .near_radius = 12};

double distance(cv::Point a, cv::Point b) {
  return std::hypot(a.x - b.x, a.y - b.y);
}

TEST(RandomNegatives, AThirdIsNearNoneTooNearAndAllPatchesLieInside) {
  Random random(1);
  const cv::Point feature(30, 60);
  const auto positions = random_negatives({320, 240}, {}, feature, 300, rules, random);
  ASSERT_EQ(positions.size(), 300u);
  int near = 0;
  double nearest = 100;
  for (const auto &p : positions) {
    nearest = std::min(nearest, distance(p, feature));
    near += distance(p, feature) <= 12;
    EXPECT_TRUE(cv::Rect(10, 10, 300, 220).contains(p)) << p;
  }
  EXPECT_GT(nearest, 4);
  EXPECT_LT(nearest, 5);  // of 100 among the 392 positions from 4 to 12 px; 20 are nearer than 5
  // 100 by rule; of the other 200 about 200·π·(144−16)/66000 = 1.2 by chance.
  EXPECT_GE(near, 100);
  EXPECT_LE(near, 110);
}

TEST(RandomNegatives, AvoidTheForbiddenArea) {
  Random random(1);
  cv::Mat forbidden(240, 320, CV_8UC1, cv::Scalar(0));
  forbidden.colRange(100, 320).setTo(255);
  const auto positions = random_negatives(forbidden.size(), forbidden, {30, 60}, 100, rules, random);
  EXPECT_GT(positions.size(), 90u);
  for (const auto &p : positions) EXPECT_LT(p.x, 100);
  forbidden.setTo(255);
  EXPECT_TRUE(random_negatives(forbidden.size(), forbidden, {30, 60}, 100, rules, random).empty());
}

TEST(RandomNegatives, APictureSmallerThanAPatchHasNone) {
  Random random(1);
  EXPECT_TRUE(random_negatives({20, 240}, {}, {5, 5}, 10, rules, random).empty());
  EXPECT_TRUE(random_negatives({1, 1}, {}, {0, 0}, 10, rules, random).empty());
}

class SimilarNegatives : public testing::Test {
 protected:
  // Noise with the same disc at three places, and a fainter, inverted disc at a fourth.
  SimilarNegatives() : picture_(200, 300, CV_8UC1) {
    cv::RNG rng(3);
    rng.fill(picture_, cv::RNG::NORMAL, 120, 4);
    for (const auto &p : {a_, b_, c_}) cv::circle(picture_, p, 5, cv::Scalar(200), cv::FILLED);
    cv::circle(picture_, d_, 5, cv::Scalar(80), cv::FILLED);
  }
  const cv::Point a_{100, 100}, b_{130, 90}, c_{90, 130}, d_{120, 120};
  cv::Mat picture_;
};

TEST_F(SimilarNegatives, AreWhereTheFeatureIsRepeated) {
  const auto positions = similar_negatives(picture_, {}, a_, 20, 0.5, 50, rules);
  ASSERT_EQ(positions.size(), 2u);
  for (const auto &p : positions) EXPECT_TRUE(distance(p, b_) < 1.5 || distance(p, c_) < 1.5) << p;
  EXPECT_GT(distance(positions[0], positions[1]), 20);
}

TEST_F(SimilarNegatives, RespectTheMaximumNumberAndTheRadius) {
  EXPECT_EQ(similar_negatives(picture_, {}, a_, 1, 0.5, 50, rules).size(), 1u);
  EXPECT_TRUE(similar_negatives(picture_, {}, a_, 20, 0.5, 20, rules).empty());
}

// A disc with a hole correlates less than a whole one. It comes second, and not at all if the limit is above its
// correlation.
TEST_F(SimilarNegatives, TheMostSimilarComesFirstAndTheLimitHolds) {
  cv::circle(picture_, b_, 2, cv::Scalar(120), cv::FILLED);
  const auto all = similar_negatives(picture_, {}, a_, 20, 0.5, 50, rules);
  ASSERT_EQ(all.size(), 2u);
  EXPECT_LT(distance(all[0], c_), 1.5);
  EXPECT_LT(distance(all[1], b_), 1.5);
  cv::Mat score;
  const auto around = [&](cv::Point p) { return picture_({p.x - 10, p.y - 10, 21, 21}); };
  cv::matchTemplate(around(all[1]), around(a_), score, cv::TM_CCOEFF_NORMED);
  const double s = score.at<float>(0, 0);
  EXPECT_EQ(similar_negatives(picture_, {}, a_, 20, s - 0.01, 50, rules).size(), 2u);
  EXPECT_EQ(similar_negatives(picture_, {}, a_, 20, s + 0.01, 50, rules).size(), 1u);
}

TEST_F(SimilarNegatives, AvoidTheForbiddenArea) {
  cv::Mat forbidden(picture_.size(), CV_8UC1, cv::Scalar(0));
  cv::circle(forbidden, b_, 4, cv::Scalar(255), cv::FILLED);
  const auto positions = similar_negatives(picture_, forbidden, a_, 20, 0.5, 50, rules);
  ASSERT_EQ(positions.size(), 1u);
  EXPECT_LT(distance(positions[0], c_), 1.5);
}

TEST_F(SimilarNegatives, AFlatPictureHasNone) {
  const cv::Mat flat(200, 300, CV_8UC1, cv::Scalar(90));
  EXPECT_TRUE(similar_negatives(flat, {}, a_, 20, 0.5, 50, rules).empty());
}

}  // namespace
}  // namespace csd
