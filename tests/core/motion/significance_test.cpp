// SPDX-License-Identifier: LGPL-2.1-or-later
#include "motion/significance.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

namespace csd::motion {
namespace {

TEST(FTail, EqualsItsClosedForms) {
  // Of 2 and m degrees of freedom: (1 + 2 r / m)^(−m/2). Of m and 2: 1 − (1 + 2 / (m r))^(−m/2).
  for (const double m : {1., 4., 10., 57.5, 4000.})
    for (const double r : {.01, .5, 1., 3., 40., 1e4}) {
      const double expected = std::pow(1 + 2 * r / m, -m / 2);
      if (expected > 1e-290) {
        EXPECT_NEAR(f_tail(r, 2, m) / expected, 1, 1e-9) << m << " " << r;
      }
      EXPECT_NEAR(f_tail(r, m, 2), 1 - std::pow(1 + 2 / (m * r), -m / 2), 1e-9) << m << " " << r;
    }
  EXPECT_EQ(f_tail(0, 3, 4), 1);
}

TEST(FTail, EqualsTheTables) {
  // Upper 5 % and 1 % points of F.
  EXPECT_NEAR(f_tail(3.3258, 5, 10), .05, 1e-5);
  EXPECT_NEAR(f_tail(2.3479, 10, 20), .05, 1e-5);
  EXPECT_NEAR(f_tail(1.8409, 30, 30), .05, 1e-5);
  EXPECT_NEAR(f_tail(5.6363, 5, 10), .01, 1e-5);
}

std::vector<double> noise(std::size_t count, unsigned seed, double exponent = 0) {
  std::mt19937 random(seed);
  std::exponential_distribution<double> power(1);
  std::vector<double> spectrum(count);
  for (std::size_t i = 0; i < count; ++i) spectrum[i] = power(random) * std::pow(static_cast<double>(i + 10), exponent);
  return spectrum;
}

TEST(Background, IsTheMeanOfWhiteNoise) {
  const auto spectrum = noise(4000, 1);
  const Background background = background_at(spectrum, 10, 2000, 5, 1, 2);
  // Half of 2010 on each side, without the 9 in the middle.
  EXPECT_DOUBLE_EQ(background.width, 2 * 1005 + 1 - 9);
  EXPECT_NEAR(background.level, 1, .15);
}

TEST(Background, OtherPeaksDoNotRaiseIt) {
  auto spectrum = noise(400, 2);
  const double before = background_at(spectrum, 10, 200, 5, 1, 2).level;
  for (const std::size_t i : {150, 151, 250, 251, 198, 200, 203}) spectrum[i] = 1e6;
  EXPECT_NEAR(background_at(spectrum, 10, 200, 5, 1, 2).level / before, 1, .1);
}

TEST(Background, OfRedNoiseIsNotTooLowAtTheSlowEnd) {
  // 1/f² at the band's lowest frequencies, where all frequencies to compare with have less power.
  double sum = 0;
  for (unsigned seed = 0; seed < 200; ++seed)
    sum += background_at(noise(200, seed, -2), 10, 1, 3, 1, 2).level * std::pow(11, 2) / 200;
  EXPECT_GT(sum, .9);
  EXPECT_LT(sum, 1.5);
}

TEST(FalseAlarm, IsRarelyExceededByNoise) {
  // The highest of 200 places against all others: how often does it seem improbable?
  int alarms = 0;
  constexpr unsigned draws = 2000;
  for (unsigned seed = 0; seed < draws; ++seed) {
    const auto spectrum = noise(200, seed);
    double least = 1;
    for (std::size_t at = 0; at < spectrum.size(); ++at)
      least = std::min(least, false_alarm(spectrum[at], background_at(spectrum, 100, at, 1, 1, 2), 2,
                                          static_cast<double>(spectrum.size())));
    alarms += least < .1;
  }
  EXPECT_LT(alarms, .12 * draws);
  EXPECT_GT(alarms, .01 * draws) << "too cautious to detect anything";
}

TEST(FalseAlarm, IsUnknownWithoutABackground) {
  EXPECT_EQ(false_alarm(5, {}, 2, 10), 1);
  EXPECT_EQ(false_alarm(5, {0, 30}, 2, 10), 1);
}

}  // namespace
}  // namespace csd::motion
