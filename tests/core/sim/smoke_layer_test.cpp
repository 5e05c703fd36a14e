// SPDX-License-Identifier: LGPL-2.1-or-later
#include "sim/smoke_layer.h"

#include <gtest/gtest.h>

#include <algorithm>

namespace csd::sim {
namespace {

const cv::Size size{320, 240};

double mean_density(double time, double strength = 1) {
  const SmokeLayer s(time, strength, 2, size);
  double sum = 0;
  int n = 0;
  for (int y = 0; y < size.height; y += 8)
    for (int x = 0; x < size.width; x += 8, ++n) {
      const double d = s.density(cv::Point2d(x, y));
      EXPECT_GE(d, 0);
      EXPECT_LE(d, 0.97F);
      sum += d;
    }
  return sum / n;
}

TEST(SmokeLayer, ComesInTwoBursts) {
  EXPECT_EQ(mean_density(1), 0);
  EXPECT_GT(mean_density(4.5), 0.2);
  EXPECT_EQ(mean_density(10), 0);
  EXPECT_GT(mean_density(13.5), 0.2);
  EXPECT_EQ(mean_density(19), 0);
  EXPECT_GT(mean_density(24.5), 0.2);  // and the second burst
  EXPECT_GT(mean_density(4.5, 2), mean_density(4.5));
  EXPECT_EQ(mean_density(4.5, 0), 0);
}

TEST(SmokeLayer, MixesAsIntendedByEquation1) {
  const SmokeLayer s(4.5, 1, 2, size);
  Canvas c;
  c.resize(size);
  for (std::size_t k = 0; k < 3; ++k)
    for (int y = 0; y < size.height; ++y) std::fill_n(c.row(k, y), size.width, 40.0F);
  s.draw(c);
  for (int y = 0; y < size.height; y += 13)
    for (int x = 0; x < size.width; x += 17) {
      const double d = s.density(cv::Point2d(x, y));
      EXPECT_NEAR(c.row(0, y)[x], (1 - d) * 40 + d * 196, 0.01);
    }
}

TEST(SmokeLayer, VariesAndDriftsSmoothly) {
  const SmokeLayer s(4.5, 1, 2, size), later(4.54, 1, 2, size), much_later(6, 1, 2, size);
  double least = 1, most = 0, step = 0, change = 0, long_change = 0;
  for (int y = 0; y < size.height; ++y)
    for (int x = 0; x + 1 < size.width; ++x) {
      const cv::Point2d p(x, y);
      least = std::min<double>(least, s.density(p));
      most = std::max<double>(most, s.density(p));
      step = std::max<double>(step, std::abs(s.density(p) - s.density(cv::Point2d(x + 1, y))));
      change = std::max<double>(change, std::abs(s.density(p) - later.density(p)));
      long_change = std::max<double>(long_change, std::abs(s.density(p) - much_later.density(p)));
    }
  EXPECT_GT(most - least, 0.25);
  EXPECT_LT(step, 0.07);
  EXPECT_LT(change, 0.2);
  EXPECT_GT(long_change, 0.2);
}

}  // namespace
}  // namespace csd::sim
