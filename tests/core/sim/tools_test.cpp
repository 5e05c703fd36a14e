// SPDX-License-Identifier: LGPL-2.1-or-later
#include "sim/tools.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>

namespace csd::sim {
namespace {

const cv::Size size{640, 480};

Canvas drawn(const Tools &tools) {
  Canvas c;
  c.resize(size);
  for (std::size_t k = 0; k < 3; ++k)
    for (int y = 0; y < size.height; ++y) std::fill_n(c.row(k, y), size.width, k == 1 ? 200.0F : 0.0F);
  tools.draw(c);
  return c;
}

double covered(double time, double strength, std::uint64_t seed = 1) {
  const Tools tools(time, strength, seed, size);
  double sum = 0;
  for (int y = 0; y < size.height; y += 4)
    for (int x = 0; x < size.width; x += 4) sum += tools.cover(cv::Point2d(x, y));
  return sum / (160 * 120);
}

TEST(Tools, ComeAndGo) {
  EXPECT_EQ(covered(0.5, 1), 0);  // features are chosen earlier
  double most = 0, together = 0;
  for (double t = 0; t < 20; t += 0.5) {
    most = std::max(most, covered(t, 1));
    together += covered(t, 1) / 40;
  }
  EXPECT_GT(most, 0.08);
  EXPECT_LT(most, 0.6);
  EXPECT_GT(together, 0.03);
  EXPECT_EQ(covered(6, 0), 0);
  EXPECT_GT(covered(6, 3), covered(6, 1));
}

TEST(Tools, HideWhatTheyCoverAndShadeTheRest) {
  for (const double t : {4.0, 9.5, 15.0}) {
    const Tools tools(t, 1, 1, size);
    const Canvas c = drawn(tools);
    int shaded = 0, far = 0;
    for (int y = 0; y < size.height; ++y)
      for (int x = 0; x < size.width; ++x) {
        const float cover = tools.cover(cv::Point2d(x, y));
        if (cover >= 1) {
          EXPECT_GT(c.row(0, y)[x], 5) << "no metal at " << x << "," << y;
        }  // the ground has no blue
        if (cover <= 0) {
          EXPECT_EQ(c.row(0, y)[x], 0);
          shaded += c.row(1, y)[x] < 160;
          far += c.row(1, y)[x] == 200;
        }
      }
    EXPECT_GT(shaded, 2000);
    EXPECT_GT(far, 50000);
  }
}

// Found by a fuzzer: the joints of a hair-thin instrument coincided, and the picture became NaN.
TEST(Tools, FadeToNothing) {
  double before = 1;
  for (const double strength : {1e-2, 1e-5, 1e-8, 1e-12, 1e-14, 1e-17, 1e-30, 1e-310}) {
    double most = 0;
    for (double t = 2; t < 20; t += 3) {
      const Canvas c = drawn(Tools(t, strength, 1, size));
      for (std::size_t k = 0; k < 3; ++k)
        for (int y = 0; y < size.height; ++y)
          ASSERT_TRUE(std::all_of(c.row(k, y), c.row(k, y) + size.width, [](float v) { return std::isfinite(v); }))
              << strength << ' ' << t << ' ' << y;
      most = std::max(most, covered(t, strength));
    }
    EXPECT_LE(most, before) << strength;
    before = most;
  }
  EXPECT_EQ(before, 0);
}

TEST(Tools, SweepOverTheMiddle) {
  int times = 0;
  for (double t = 0; t < 40; t += 0.1) {
    const Tools tools(t, 1, 1, size);
    bool hit = false;
    for (int x = 200; x <= 440; x += 20)
      for (int y = 150; y <= 330; y += 20) hit |= tools.cover(cv::Point2d(x, y)) > 0.5F;
    times += hit;
  }
  EXPECT_GT(times, 100);
  EXPECT_LT(times, 390);
}

}  // namespace
}  // namespace csd::sim
