// SPDX-License-Identifier: LGPL-2.1-or-later
#include "csd2012/smoothed.h"

#include <gtest/gtest.h>

#include <cmath>

namespace csd::csd2012 {
namespace {

TEST(Smoothed, WithoutSmoothingThePictureIsUnchanged) {
  const cv::Mat picture(5, 7, CV_8UC1, cv::Scalar(3));
  cv::Mat out;
  EXPECT_EQ(smoothing_margin(0), 0);
  smooth(picture, 0, out);
  EXPECT_EQ(out.data, picture.data);
  EXPECT_EQ(out.size(), picture.size());
}

// A dot becomes a Gaussian bell: 250 / (2πσ²) in the middle, and exp(−½) of that at a distance of σ.
TEST(Smoothed, ADotBecomesABell) {
  const int margin = smoothing_margin(2);
  cv::Mat grown(21 + 2 * margin, 21 + 2 * margin, CV_8UC1, cv::Scalar(0)), out;
  grown.at<unsigned char>(margin + 10, margin + 10) = 250;
  smooth(grown, 2, out);
  ASSERT_EQ(out.size(), cv::Size(21, 21));
  EXPECT_NEAR(out.at<unsigned char>(10, 10), 250 / (8 * CV_PI), 1);
  EXPECT_NEAR(out.at<unsigned char>(10, 12), 250 / (8 * CV_PI) * std::exp(-.5), 1);
  EXPECT_NEAR(out.at<unsigned char>(12, 10), 250 / (8 * CV_PI) * std::exp(-.5), 1);
  EXPECT_EQ(out.at<unsigned char>(0, 0), 0);
}

// Pixels in the margin contribute.
TEST(Smoothed, UsesTheMargin) {
  const int margin = smoothing_margin(1);
  cv::Mat grown(5 + 2 * margin, 5 + 2 * margin, CV_8UC1, cv::Scalar(0)), out;
  grown.row(margin - 1).setTo(200);
  smooth(grown, 1, out);
  EXPECT_GT(out.at<unsigned char>(0, 2), 30);
  EXPECT_EQ(out.at<unsigned char>(4, 2), 0);
}

// Neighbours in the stack don't mix.
TEST(Smoothed, EachPatchOfAStackAsIfAlone) {
  for (const int type : {CV_8UC1, CV_8UC3})
    for (const double sigma : {0.0, 1.0, 2.0}) {
      SCOPED_TRACE(testing::Message() << "type " << type << ", sigma " << sigma);
      const int side = 21 + 2 * smoothing_margin(sigma), count = 5;
      cv::Mat stack(count * side, side, type);
      cv::RNG(7).fill(stack, cv::RNG::UNIFORM, 0, 256);
      const auto patches = smooth_each(stack, sigma);
      ASSERT_EQ(patches.size(), 5U);
      for (int i = 0; i < count; ++i) {
        cv::Mat alone;
        smooth(stack.rowRange(i * side, (i + 1) * side).clone(), sigma, alone);
        const cv::Mat &patch = patches[static_cast<std::size_t>(i)];
        ASSERT_EQ(patch.size(), cv::Size(21, 21));
        EXPECT_EQ(cv::norm(patch, alone, cv::NORM_INF), 0) << "patch " << i;
      }
    }
}

}  // namespace
}  // namespace csd::csd2012
