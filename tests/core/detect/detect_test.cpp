// SPDX-License-Identifier: LGPL-2.1-or-later
#include "detect/detect.h"

#include <gtest/gtest.h>

#include <opencv2/imgproc.hpp>

#include <cmath>

namespace {

cv::Mat noise(int rows, int cols) {
  cv::Mat result(rows, cols, CV_8UC1);
  cv::RNG rng(3);
  rng.fill(result, cv::RNG::UNIFORM, 60, 200);
  cv::GaussianBlur(result, result, {}, 2);
  return result;
}

TEST(Detect, FindsNothingInAnEmptyPicture) {
  for (const int grey : {0, 16, 128, 255}) {
    EXPECT_TRUE(csd::detect(cv::Mat(480, 640, CV_8UC1, cv::Scalar(grey)), {}, {}, {}).empty());
  }
  for (const int side : {1, 2, 8, 20}) EXPECT_TRUE(csd::detect(noise(side, side), {}, {}, {}).empty());
  EXPECT_TRUE(csd::detect({}, {}, {}, {}).empty());
}

/// A picture of pure noise.
cv::Mat only_noise(double mean, double deviation) {
  cv::Mat noise(480, 640, CV_16SC1), result;
  cv::RNG(4).fill(noise, cv::RNG::NORMAL, mean, deviation);
  noise.convertTo(result, CV_8U);
  return result;
}

TEST(Detect, FindsNothingInNoise) {
  for (const double deviation : {0.5, 2.0, 5.0, 20.0}) {
    EXPECT_TRUE(csd::detect(only_noise(128, deviation), {}, {}, {}).empty()) << deviation;
  }
  // Including black and white pictures, where the noise is clipped on one side.
  for (const int grey : {0, 16, 235, 255}) {
    EXPECT_TRUE(csd::detect(only_noise(grey, 0.5), {}, {}, {}).empty()) << grey;
  }
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

}  // namespace
