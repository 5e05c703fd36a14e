// SPDX-License-Identifier: LGPL-2.1-or-later
#include "image/pyramid.h"

#include <gtest/gtest.h>

#include <cmath>
#include <stdexcept>

namespace csd {
namespace {

cv::Mat noise(cv::Size size, std::uint64_t seed = 1) {
  cv::Mat out(size, CV_8UC1);
  cv::RNG(seed).fill(out, cv::RNG::UNIFORM, 0, 256);
  return out;
}

/// …2 1 0 1 2 … n−2 n−1 n−2 …
int mirrored(int i, int n) {
  if (n == 1) return 0;
  const int period = 2 * (n - 1);
  i = ((i % period) + period) % period;
  return i < n ? i : period - i;
}

constexpr double binomial[] = {1. / 16, 4. / 16, 6. / 16, 4. / 16, 1. / 16};

/// Both filters in double: 1 4 6 4 1 in both directions, then every `step`-th pixel.
cv::Mat1d filtered(const cv::Mat1d &in, int step) {
  cv::Mat1d out((in.rows + step - 1) / step, (in.cols + step - 1) / step);
  for (int y = 0; y < out.rows; ++y)
    for (int x = 0; x < out.cols; ++x) {
      double sum = 0;
      for (int j = -2; j <= 2; ++j)
        for (int i = -2; i <= 2; ++i)
          sum +=
              binomial[j + 2] * binomial[i + 2] * in(mirrored(step * y + j, in.rows), mirrored(step * x + i, in.cols));
      out(y, x) = sum;
    }
  return out;
}

void expect_as_defined(const cv::Mat &luma) {
  SCOPED_TRACE(testing::Message() << luma.cols << " x " << luma.rows);
  Pyramid pyramid;
  pyramid.build(luma);
  cv::Mat1d below;
  luma.convertTo(below, CV_64F, 256);
  for (int l = 0; l < Pyramid::levels; ++l) {
    const cv::Mat1d exact = filtered(below, l == 0 ? 1 : 2);
    const cv::Mat &level = pyramid.level(l);
    ASSERT_EQ(level.type(), CV_16UC1);
    ASSERT_EQ(level.size(), exact.size());
    for (int y = 0; y < exact.rows; ++y)
      for (int x = 0; x < exact.cols; ++x)
        ASSERT_EQ(level.at<std::uint16_t>(y, x), std::floor(exact(y, x) + .5)) << l << ": " << x << "," << y;
    level.convertTo(below, CV_64F);  // each level comes from the rounded one below
  }
}

TEST(Pyramid, LevelsAreTheRoundedFilters) {
  for (const cv::Size size : {cv::Size(16, 16), cv::Size(17, 16), cv::Size(16, 19), cv::Size(33, 31), cv::Size(64, 48),
                              cv::Size(101, 77), cv::Size(200, 18), cv::Size(19, 130)})
    expect_as_defined(noise(size));
}

TEST(Pyramid, KeepsFullBlackAndWhite) {
  for (const int grey : {0, 1, 254, 255}) {
    Pyramid pyramid;
    pyramid.build(cv::Mat(40, 50, CV_8UC1, cv::Scalar(grey)));
    for (int l = 0; l < Pyramid::levels; ++l) {
      double low, high;
      cv::minMaxLoc(pyramid.level(l), &low, &high);
      EXPECT_EQ(low, 256 * grey);
      EXPECT_EQ(high, 256 * grey);
    }
  }
}

TEST(Pyramid, AcceptsRowsWithGaps) {
  const cv::Mat wide = noise({90, 60});
  expect_as_defined(wide({13, 7, 53, 41}));
}

TEST(Pyramid, PixelsLieAtMultiplesOfTwoToTheLevel) {
  // A plane that rises by 1/2 in x and 1/4 in y; only near the border it doesn't.
  cv::Mat luma(256, 256, CV_8UC1);
  for (int y = 0; y < 256; ++y)
    for (int x = 0; x < 256; ++x) luma.ptr(y)[x] = static_cast<std::uint8_t>(x / 2 + y / 4);
  Pyramid pyramid;
  pyramid.build(luma);
  for (int l = 2; l < Pyramid::levels; ++l) {
    const int at = 128 >> l;
    // floor() loses 1/4 and 3/8 on average.
    EXPECT_NEAR(pyramid.level(l).at<std::uint16_t>(at, at) / 256., 128 / 2. - .25 + 128 / 4. - .375, .02) << l;
  }
}

TEST(Pyramid, SmoothingHasTheVarianceOfTheGaussian) {
  cv::Mat luma = cv::Mat::zeros(32, 32, CV_8UC1);
  luma.at<std::uint8_t>(16, 16) = 255;
  Pyramid pyramid;
  pyramid.build(luma);
  double sum = 0, x2 = 0, y2 = 0;
  for (int y = 0; y < 32; ++y)
    for (int x = 0; x < 32; ++x) {
      const double w = pyramid.level(0).at<std::uint16_t>(y, x);
      sum += w;
      x2 += w * (x - 16) * (x - 16);
      y2 += w * (y - 16) * (y - 16);
    }
  EXPECT_EQ(sum, 255 * 256);
  EXPECT_DOUBLE_EQ(x2 / sum, 1);
  EXPECT_DOUBLE_EQ(y2 / sum, 1);
}

TEST(Pyramid, RefusesOtherPictures) {
  Pyramid pyramid;
  EXPECT_TRUE(pyramid.empty());
  EXPECT_THROW(pyramid.build(cv::Mat(15, 16, CV_8UC1)), std::invalid_argument);
  EXPECT_THROW(pyramid.build(cv::Mat(16, 15, CV_8UC1)), std::invalid_argument);
  EXPECT_THROW(pyramid.build(cv::Mat(16, 16, CV_16UC1)), std::invalid_argument);
  EXPECT_TRUE(pyramid.empty());
}

}  // namespace
}  // namespace csd
