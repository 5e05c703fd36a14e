// SPDX-License-Identifier: LGPL-2.1-or-later
#include "image/convert.h"

#include <gtest/gtest.h>

namespace csd {
namespace {

TEST(ToSpace, AppliesTheSpaceToEachPixel) {
  cv::Mat bgr(7, 53, CV_8UC3), out;
  cv::RNG rng(1);
  rng.fill(bgr, cv::RNG::UNIFORM, 0, 256);
  const cv::Mat part = bgr(cv::Rect(3, 1, 41, 5));  // rows with a gap between them
  for (const auto &space : colour_spaces()) {
    to_space(part, space, out);
    ASSERT_EQ(out.type(), CV_8UC1);
    ASSERT_EQ(out.size(), part.size());
    for (int y = 0; y < part.rows; ++y)
      for (int x = 0; x < part.cols; ++x) {
        const auto &p = part.at<cv::Vec3b>(y, x);
        ASSERT_EQ(out.at<unsigned char>(y, x), space.apply(p[2], p[1], p[0]));
      }
  }
}

TEST(ToSpace, RequiresColour) {
  cv::Mat out;
  EXPECT_THROW(to_space(cv::Mat(3, 3, CV_8UC1, cv::Scalar(0)), {1, 1, 1}, out), cv::Exception);
}

}  // namespace
}  // namespace csd
