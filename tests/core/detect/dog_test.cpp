// SPDX-License-Identifier: LGPL-2.1-or-later
#include "detect/dog.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace {

TEST(Dog, FindsBlobsWhereTheyAre) {
  const cv::Point2d a(100, 80), b(220, 130);
  cv::Mat luma(240, 320, CV_8UC1);
  for (int y = 0; y < luma.rows; ++y) {
    for (int x = 0; x < luma.cols; ++x) {
      const double ra = std::hypot(x - a.x, y - a.y) / 6, rb = std::hypot(x - b.x, y - b.y) / 8;
      const double value = 120 + 90 * std::exp(-ra * ra / 2) - 90 * std::exp(-rb * rb / 2);
      luma.at<std::uint8_t>(y, x) = static_cast<std::uint8_t>(std::lround(value));
    }
  }
  cv::Mat allowed(luma.size(), CV_8UC1, cv::Scalar(255));
  const csd::Candidates found = csd::find_dog(luma, allowed);
  ASSERT_EQ(found.size(), 2U);
  for (const cv::Point2d &blob : {a, b}) {
    EXPECT_LT(std::min(cv::norm(found[0].at - blob), cv::norm(found[1].at - blob)), 0.3) << blob;
  }
  allowed.colRange(0, 160).setTo(0);
  const csd::Candidates right = csd::find_dog(luma, allowed);
  ASSERT_EQ(right.size(), 1U);
  EXPECT_LT(cv::norm(right[0].at - b), 0.3);
}

}  // namespace
