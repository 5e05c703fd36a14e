// SPDX-License-Identifier: LGPL-2.1-or-later
#include "sim/sensor.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <opencv2/imgproc.hpp>

namespace csd::sim {
namespace {

const cv::Size size{320, 240};

cv::Mat expose(const std::string &effects, cv::Scalar colour, std::uint64_t moment = 0, cv::Vec3d gain = {1, 1, 1}) {
  Effects e;
  e.set(effects);
  Canvas c;
  c.resize(size);
  for (int k = 0; k < 3; ++k)
    for (int y = 0; y < size.height; ++y)
      std::fill_n(c.row(static_cast<std::size_t>(k), y), size.width, static_cast<float>(colour[k]));
  cv::Mat picture;
  std::vector<float> scratch;
  Sensor(e, 1).expose(c, gain, moment, picture, scratch);
  return picture;
}

double luma_deviation(const cv::Mat &picture) {
  cv::Mat grey;
  cv::cvtColor(picture, grey, cv::COLOR_BGR2GRAY);
  cv::Scalar mean, deviation;
  cv::meanStdDev(grey, mean, deviation);
  return deviation[0];
}

TEST(Sensor, RoundsAndClips) {
  const cv::Mat p = expose("", {10.4, 300, -5});
  EXPECT_EQ(p.at<cv::Vec3b>(7, 9), cv::Vec3b(10, 255, 0));
  EXPECT_EQ(expose("", {100, 100, 100}, 0, {0.5, 1, 1.5}).at<cv::Vec3b>(0, 0), cv::Vec3b(50, 100, 150));
}

TEST(Sensor, NoiseGrowsWithTheSignal) {
  // σ² = 4·(0.4 + 0.6·luma/128), and 1/12 from rounding.
  for (const double luma : {40.0, 128.0, 200.0}) {
    const double expected = std::sqrt(4 * (0.4 + 0.6 * luma / 128) + 1.0 / 12);
    EXPECT_NEAR(luma_deviation(expose("noise", cv::Scalar::all(luma))), expected, 0.1) << luma;
  }
  EXPECT_NEAR(luma_deviation(expose("noise=2", cv::Scalar::all(128))), 4, 0.2);
  EXPECT_EQ(luma_deviation(expose("", cv::Scalar::all(128))), 0);
}

TEST(Sensor, NoiseDiffersEachMoment) {
  const cv::Mat a = expose("noise", cv::Scalar::all(128), 0), b = expose("noise", cv::Scalar::all(128), 1),
                difference = a - b + (b - a);
  cv::Mat signed_a, signed_b;
  a.convertTo(signed_a, CV_32F, 1, -128);
  b.convertTo(signed_b, CV_32F, 1, -128);
  const double correlation = signed_a.dot(signed_b) / std::sqrt(signed_a.dot(signed_a) * signed_b.dot(signed_b));
  EXPECT_LT(std::abs(correlation), 0.02);
  // Nor do rows repeat.
  const double rows = signed_a.row(10).dot(signed_a.row(11)) / signed_a.row(10).dot(signed_a.row(10));
  EXPECT_LT(std::abs(rows), 0.15);
}

TEST(Sensor, ChromaIsSofterThanLuma) {
  Effects e;
  e.set("chroma");
  Canvas c;
  c.resize(size);
  for (int y = 0; y < size.height; ++y)
    for (int x = 0; x < size.width; ++x) {
      // The upper half has a step of colour at constant luma, the lower half a step of luma at constant colour.
      const bool right = x >= 160, upper = y < 120;
      c.row(0, y)[x] = upper ? 100 : right ? 150.0F : 50.0F;
      c.row(1, y)[x] = upper ? 100 + (right ? -0.299F / 0.587F * 50 : 0) : right ? 150.0F : 50.0F;
      c.row(2, y)[x] = upper ? 100 + (right ? 50.0F : 0) : right ? 150.0F : 50.0F;
    }
  cv::Mat p;
  std::vector<float> scratch;
  Sensor(e, 1).expose(c, {1, 1, 1}, 0, p, scratch);
  EXPECT_NEAR(p.at<cv::Vec3b>(60, 159)[2], 118, 8);  // half-way from 100 to 150
  EXPECT_NEAR(p.at<cv::Vec3b>(60, 150)[2], 100, 1);
  EXPECT_NEAR(p.at<cv::Vec3b>(60, 170)[2], 150, 1);
  EXPECT_EQ(p.at<cv::Vec3b>(200, 159), cv::Vec3b(50, 50, 50));
  EXPECT_EQ(p.at<cv::Vec3b>(200, 160), cv::Vec3b(150, 150, 150));
}

TEST(Sensor, HasARoundFieldStop) {
  const cv::Mat p = expose("field-stop", cv::Scalar::all(100));
  Effects e;
  e.set("field-stop");
  const Sensor sensor(e, 1);
  EXPECT_EQ(p.at<cv::Vec3b>(120, 160), cv::Vec3b::all(100));
  EXPECT_EQ(p.at<cv::Vec3b>(0, 0), cv::Vec3b::all(0));
  // Its radius is 0.58 of the height: 139 pixels.
  EXPECT_EQ(p.at<cv::Vec3b>(120, 160 + 135), cv::Vec3b::all(100));
  EXPECT_EQ(p.at<cv::Vec3b>(120, 160 + 144), cv::Vec3b::all(0));
  EXPECT_EQ(sensor.stopped({160, 120}, size), 0);
  EXPECT_EQ(sensor.stopped({0, 0}, size), 1);
}

}  // namespace
}  // namespace csd::sim
