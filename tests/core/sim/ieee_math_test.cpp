// SPDX-License-Identifier: LGPL-2.1-or-later
#include "sim/ieee_math.h"

#include <gtest/gtest.h>

#include <cmath>

namespace csd::sim {
namespace {

TEST(IeeeMath, SineAndCosineAreExactEnough) {
  for (double t = -3.3; t < 3.3; t += 0.00137) {
    EXPECT_NEAR(sin_turns(t), std::sin(2 * M_PI * t), 1e-11) << t;
    EXPECT_NEAR(cos_turns(t), std::cos(2 * M_PI * t), 1e-11) << t;
  }
  EXPECT_EQ(sin_turns(0), 0);
  EXPECT_NEAR(sin_turns(0.25), 1, 1e-11);
  EXPECT_NEAR(sin_turns(1000000.25), 1, 1e-9);
}

TEST(IeeeMath, TheExponentialIsExactEnough) {
  for (double x = -699; x < 699; x += 0.317) EXPECT_NEAR(exp_of(x) / std::exp(x), 1, 1e-13) << x;
  EXPECT_EQ(exp_of(0), 1);
  EXPECT_EQ(exp_of(-701), 0);
  EXPECT_TRUE(std::isnan(exp_of(std::nan(""))));
}

TEST(IeeeMath, TheLogarithmIsExactEnough) {
  for (double x = 1e-9; x < 1e9; x *= 1.0173) EXPECT_NEAR(log2_of(x), std::log2(x), 1e-10) << x;
  EXPECT_EQ(log2_of(1), 0);
  EXPECT_EQ(log2_of(8), 3);
}

TEST(IeeeMath, StepsAndWindowsHaveKnownValues) {
  EXPECT_EQ(smoothstep(-1.0), 0);
  EXPECT_EQ(smoothstep(0.5), 0.5);
  EXPECT_EQ(smoothstep(2.0), 1);
  EXPECT_EQ(window(1, 2, 1, 6, 1), 0);
  EXPECT_EQ(window(2.5, 2, 1, 6, 1), 0.5);
  EXPECT_EQ(window(4, 2, 1, 6, 1), 1);
  EXPECT_EQ(window(5.5, 2, 1, 6, 1), 0.5);
  EXPECT_EQ(window(6, 2, 1, 6, 1), 0);
}

TEST(IeeeMath, RandomValuesDependOnTheirIndexOnly) {
  double sum = 0;
  for (int i = -500; i < 500; ++i) {
    const double x = hashed(7, 3, i);
    EXPECT_GE(x, 0);
    EXPECT_LT(x, 1);
    EXPECT_EQ(x, hashed(7, 3, i));
    EXPECT_NE(x, hashed(7, 4, i));
    EXPECT_NE(x, hashed(8, 3, i));
    sum += x;
  }
  EXPECT_NEAR(sum / 1000, 0.5, 0.03);
}

TEST(IeeeMath, WanderIsSmooth) {
  double lowest = 1, highest = -1;
  for (double t = -50; t < 50; t += 0.01) {
    EXPECT_NEAR(wander(1, 2, t), wander(1, 2, t + 1e-6), 1e-5);
    lowest = std::min(lowest, wander(1, 2, t));
    highest = std::max(highest, wander(1, 2, t));
  }
  EXPECT_LT(lowest, -0.8);
  EXPECT_GT(highest, 0.8);
  EXPECT_GE(lowest, -1);
  EXPECT_LE(highest, 1);
}

}  // namespace
}  // namespace csd::sim
