// SPDX-License-Identifier: LGPL-2.1-or-later
#include "csd2012/learn/leaf_patches.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <opencv2/imgproc.hpp>

namespace csd {
namespace {

constexpr int side = 21;

cv::Mat noise(int seed) {
  cv::Mat m(side, side, CV_8UC1);
  cv::RNG(static_cast<std::uint64_t>(seed)).fill(m, cv::RNG::UNIFORM, 0, 256);
  return m;
}

LeafPatches of(std::initializer_list<cv::Mat> patches) {
  LeafPatches own(side * side);
  for (const auto &patch : patches) own.add(patch.data);
  return own;
}

TEST(LeafPatches, TheMostAlikeCountsAsOpenCvCorrelatesThem) {
  const LeafPatches own = of({noise(1), noise(2), noise(3)});
  ASSERT_EQ(own.size(), 3u);
  for (int i = 10; i < 30; ++i) {
    const cv::Mat patch = noise(i) / 2 + noise(1 + i % 3) / 2;
    double expected = 0;
    for (int k = 1; k <= 3; ++k) {
      cv::Mat correlation;
      cv::matchTemplate(patch, noise(k), correlation, cv::TM_CCOEFF_NORMED);
      expected = std::max<double>(expected, correlation.at<float>(0, 0));
    }
    EXPECT_NEAR(own.likeness(patch.data), expected, 1e-5) << i;
  }
}

TEST(LeafPatches, GainAndBiasDoNotMatter) {
  const LeafPatches own = of({noise(1)});
  EXPECT_DOUBLE_EQ(own.likeness(noise(1).data), 1);
  const cv::Mat darker = noise(1) / 2 + 20;
  EXPECT_NEAR(own.likeness(darker.data), 1, 1e-4);  // rounded to whole grey levels
}

TEST(LeafPatches, WhatDoesNotCorrelateIsNotAlike) {
  const LeafPatches own = of({noise(1)});
  const cv::Mat negative = 255 - noise(1), flat(side, side, CV_8UC1, cv::Scalar(90));
  EXPECT_EQ(own.likeness(negative.data), 0);
  EXPECT_EQ(own.likeness(flat.data), 0);
  EXPECT_EQ(of({flat}).likeness(noise(1).data), 0);
  EXPECT_EQ(of({}).likeness(noise(1).data), 0);
}

// The largest patch with the largest values: nothing overflows.
TEST(LeafPatches, TheLargestPatchFits) {
  constexpr int most = 255;
  cv::Mat bright(most, most, CV_8UC1, cv::Scalar(255)), other = bright.clone();
  bright.at<std::uint8_t>(0, 0) = 0;
  other.at<std::uint8_t>(9, 9) = 0;
  LeafPatches own(most * most);
  own.add(bright.data);
  EXPECT_DOUBLE_EQ(own.likeness(bright.data), 1);
  EXPECT_EQ(own.likeness(other.data), 0);
}

}  // namespace
}  // namespace csd
