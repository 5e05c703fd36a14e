// SPDX-License-Identifier: LGPL-2.1-or-later
#include "sim/canvas.h"

#include <gtest/gtest.h>

#include <algorithm>

namespace csd::sim {
namespace {

Canvas impulse(cv::Size size, cv::Point at, float value) {
  Canvas c;
  c.resize(size);
  for (std::size_t k = 0; k < 3; ++k)
    for (int y = 0; y < size.height; ++y) std::fill_n(c.row(k, y), size.width, 0.0F);
  c.row(1, at.y)[at.x] = value;
  return c;
}

TEST(Blur, SpreadsLikeAGaussian) {
  for (const double sigma : {0.8, 1.5, 3.0}) {
    Canvas c = impulse({61, 51}, {30, 25}, 1000);
    std::vector<float> scratch;
    blur(c, 1, sigma, scratch);
    double sum = 0, x = 0, y = 0, xx = 0, yy = 0;
    for (int j = 0; j < 51; ++j)
      for (int i = 0; i < 61; ++i) {
        const double v = c.row(1, j)[i];
        sum += v;
        x += v * i;
        y += v * j;
        xx += v * (i - 30) * (i - 30);
        yy += v * (j - 25) * (j - 25);
        EXPECT_EQ(c.row(0, j)[i], 0);
      }
    EXPECT_NEAR(sum, 1000, 0.1);
    EXPECT_NEAR(x / sum, 30, 1e-4);
    EXPECT_NEAR(y / sum, 25, 1e-4);
    // Cut off at 2.5σ: a little narrower.
    EXPECT_NEAR(xx / sum / (sigma * sigma), 0.95, 0.07);
    EXPECT_NEAR(yy / sum, xx / sum, 0.01);
  }
}

TEST(Blur, ReplicatesTheBorder) {
  Canvas c = impulse({20, 10}, {0, 0}, 0);
  for (int y = 0; y < 10; ++y) std::fill_n(c.row(1, y), 20, 42.0F);
  std::vector<float> scratch;
  blur(c, 1, 2, scratch);
  for (int y = 0; y < 10; ++y)
    for (int x = 0; x < 20; ++x) EXPECT_NEAR(c.row(1, y)[x], 42, 1e-4);
}

TEST(Blur, OfNothingDoesNothing) {
  Canvas c = impulse({9, 9}, {4, 4}, 10);
  std::vector<float> scratch;
  blur(c, 1, 0.1, scratch);
  EXPECT_EQ(c.row(1, 4)[4], 10);
}

}  // namespace
}  // namespace csd::sim
