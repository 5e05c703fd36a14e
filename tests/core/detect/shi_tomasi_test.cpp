// SPDX-License-Identifier: LGPL-2.1-or-later
#include "detect/shi_tomasi.h"

#include <gtest/gtest.h>

#include <cmath>

namespace {

// The eigenvalue is constant while the window moves over the corner, so the maximum may be off by half a window.
TEST(ShiTomasi, FindsCornersOfACheckerboard) {
  cv::Mat luma(160, 200, CV_8UC1);
  for (int y = 0; y < luma.rows; ++y) {
    for (int x = 0; x < luma.cols; ++x) luma.at<std::uint8_t>(y, x) = (x / 40 + y / 40) % 2 == 0 ? 60 : 180;
  }
  const cv::Mat all(luma.size(), CV_8UC1, cv::Scalar(255));
  const csd::Candidates found = csd::find_shi_tomasi(luma, all, 7, 10);
  EXPECT_EQ(found.size(), 4U * 3U);
  for (const csd::Candidate &c : found) {
    EXPECT_LE(std::abs(std::remainder(c.at.x - 39.5, 40)), 3.5) << c.at;
    EXPECT_LE(std::abs(std::remainder(c.at.y - 39.5, 40)), 3.5) << c.at;
  }
}

// Fields that differ by one grey level, as coding leaves them in a flat picture.
TEST(ShiTomasi, IgnoresTheFaintestCheckerboard) {
  cv::Mat luma(160, 200, CV_8UC1);
  for (int y = 0; y < luma.rows; ++y) {
    for (int x = 0; x < luma.cols; ++x) luma.at<std::uint8_t>(y, x) = (x / 40 + y / 40) % 2 == 0 ? 60 : 61;
  }
  EXPECT_TRUE(csd::find_shi_tomasi(luma, cv::Mat(luma.size(), CV_8UC1, cv::Scalar(255)), 7, 10).empty());
}

TEST(ShiTomasi, AStraightEdgeIsNotACorner) {
  cv::Mat luma(100, 100, CV_8UC1, cv::Scalar(60));
  luma.colRange(50, 100).setTo(180);
  EXPECT_TRUE(csd::find_shi_tomasi(luma, cv::Mat(luma.size(), CV_8UC1, cv::Scalar(255)), 7, 10).empty());
}

TEST(ShiTomasi, NoiseHasNoCorners) {
  for (const int window : {3, 7, 21}) {
    for (const double deviation : {1.0, 3.0, 10.0, 30.0}) {
      cv::Mat noise(480, 640, CV_16SC1), luma;
      cv::RNG(4).fill(noise, cv::RNG::NORMAL, 120, deviation);
      noise.convertTo(luma, CV_8U);
      const cv::Mat all(luma.size(), CV_8UC1, cv::Scalar(255));
      EXPECT_TRUE(csd::find_shi_tomasi(luma, all, window, 10).empty()) << window << ' ' << deviation;
      luma(cv::Rect(300, 200, 60, 60)) += 6 * deviation;
      EXPECT_EQ(csd::find_shi_tomasi(luma, all, window, 30).size(), 4U) << window << ' ' << deviation;
    }
  }
}

}  // namespace
