// SPDX-License-Identifier: LGPL-2.1-or-later
#include "baselines/mean_shift.h"

#include <gtest/gtest.h>

namespace csd {
namespace {

/// The weights are the grey values themselves.
ColourWeights identity() {
  ColourWeights w{};
  for (std::size_t i = 0; i < w.size(); ++i) w[i] = static_cast<std::uint8_t>(i);
  return w;
}

TEST(MeanShift, OneStepGoesToTheWindowsCentroid) {
  cv::Mat values(11, 11, CV_8UC1, cv::Scalar(0));
  values.at<std::uint8_t>(5, 7) = 3;
  values.at<std::uint8_t>(7, 5) = 1;
  values.at<std::uint8_t>(5, 8) = 200;  // outside the window
  const auto window = window_mass(values, identity(), {5.2, 4.8}, 5);
  EXPECT_EQ(window.mass, 4u);
  EXPECT_DOUBLE_EQ(window.centroid.x, 6.5);  // (3·7 + 1·5) / 4
  EXPECT_DOUBLE_EQ(window.centroid.y, 5.5);  // (3·5 + 1·7) / 4
}

TEST(MeanShift, CutsWindowsOffAtTheEdge) {
  const cv::Mat values(4, 4, CV_8UC1, cv::Scalar(1));
  const auto window = window_mass(values, identity(), {0, 3}, 5);
  EXPECT_EQ(window.mass, 9u);
  EXPECT_DOUBLE_EQ(window.centroid.x, 1);
  EXPECT_DOUBLE_EQ(window.centroid.y, 2);
  EXPECT_EQ(window_mass(values, identity(), {40, 40}, 5).mass, 0u);
}

TEST(MeanShift, ClimbsToAnOverlappingBlob) {
  cv::Mat values(30, 30, CV_8UC1, cv::Scalar(0));
  values({12, 9, 7, 7}).setTo(50);  // centre 15,12
  const auto found = mean_shift(values, identity(), {10, 8}, 9);
  ASSERT_TRUE(found);
  EXPECT_DOUBLE_EQ(found->x, 15);
  EXPECT_DOUBLE_EQ(found->y, 12);
}

TEST(MeanShift, FindsNothingWithoutOverlap) {
  cv::Mat values(30, 30, CV_8UC1, cv::Scalar(0));
  values({12, 9, 7, 7}).setTo(50);
  EXPECT_TRUE(mean_shift(values, identity(), {9, 12}, 7));  // one column of 7 overlaps
  EXPECT_FALSE(mean_shift(values, identity(), {8, 12}, 7));
}

}  // namespace
}  // namespace csd
