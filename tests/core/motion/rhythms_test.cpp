// SPDX-License-Identifier: LGPL-2.1-or-later
#include "motion/rhythms.h"

#include <gtest/gtest.h>

#include "signals.h"

namespace csd::motion {
namespace {

/// Each feature's rhythms.
std::vector<Rhythms> each(const Series &series, const SearchOptions &options = {}) {
  std::vector<std::vector<std::size_t>> groups;
  for (std::size_t i = 0; i < series.paths.size(); ++i) groups.push_back({i});
  return find_rhythms(series, groups, options);
}

Rhythms together(const Series &series, const SearchOptions &options = {}) {
  std::vector<std::size_t> all;
  for (std::size_t i = 0; i < series.paths.size(); ++i) all.push_back(i);
  return find_rhythms(series, {all}, options).front();
}

/// The rhythm near a frequency, or an empty one.
Rhythm near(const Rhythms &found, double frequency) {
  for (const Rhythm &rhythm : found.rhythms)
    if (std::abs(rhythm.frequency - frequency) < .1 * frequency) return rhythm;
  return {};
}

/// A breath of 3 px along a slope, a heartbeat of 1 px along x with a second harmonic, and drift.
cv::Point2d tissue(std::size_t feature, double t) {
  const auto f = static_cast<double>(feature);
  const double breath = 3 * sine(.2371 * t + .1 * f), heart = sine(1.3127 * t + .2 * f) + .4 * sine(2.6254 * t);
  return {200 + .6 * breath + heart + .3 * t, 100 + .8 * breath - .002 * t * t};
}

void expect_tissue(const Rhythms &found) {
  ASSERT_EQ(found.rhythms.size(), 2u);
  const Rhythm &breath = found.rhythms[0], &heart = found.rhythms[1];
  EXPECT_NEAR(breath.frequency, .2371, .0010);
  EXPECT_NEAR(breath.period(), 1 / .2371, .02);
  EXPECT_NEAR(breath.amplitude, 3, .1);
  EXPECT_NEAR(breath.direction, 53.13, 2) << "of (0.6, 0.8)";
  EXPECT_TRUE(breath.harmonics.empty());
  EXPECT_NEAR(heart.frequency, 1.3127, .0010);
  EXPECT_NEAR(heart.amplitude, 1, .05);
  EXPECT_NEAR(heart.direction, 0, 2);
  ASSERT_EQ(heart.harmonics.size(), 1u);
  EXPECT_EQ(heart.harmonics[0].multiple, 2u);
  EXPECT_NEAR(heart.harmonics[0].amplitude, .4, .03);
  // Variances: 9/2, (1 + 0.16)/2, and noise of 2·0.2².
  EXPECT_NEAR(breath.explained, 4.5 / (4.5 + .58 + .08), .03);
  EXPECT_NEAR(heart.explained, .58 / (4.5 + .58 + .08), .02);
  EXPECT_LT(breath.false_alarm, 1e-6);
  EXPECT_LT(heart.false_alarm, 1e-6);
}

TEST(Rhythms, FindsTwoSinusoidsInNoiseAndDrift) {
  const Series series = series_of_signals(3, 60, .2, 1, tissue);
  for (const Rhythms &found : each(series)) expect_tissue(found);
  expect_tissue(together(series));
}

TEST(Rhythms, GapsAddNoRhythms) {
  // A tool every 5 s for 1.3 s, and each feature is lost for 8 s: a third is missing.
  const Series series = series_of_signals(6, 60, .2, 2, tissue, [](std::size_t f, double t) {
    const double lost = 6 * static_cast<double>(f) + 5;
    return t - 5 * std::floor(t / 5) >= 1.3 && (t < lost || t > lost + 8);
  });
  for (const Rhythms &found : each(series)) expect_tissue(found);
  expect_tissue(together(series));
}

TEST(Rhythms, FindsThemInAShortClip) {
  const Series series = series_of_signals(2, 10, .1, 3, tissue);
  for (const Rhythms &found : each(series)) {
    EXPECT_NEAR(near(found, 1.3127).frequency, 1.3127, .02 * 1.3127);
    EXPECT_EQ(found.windows, 1u);
  }
}

TEST(Rhythms, FindsNoneInWhiteNoise) {
  // At most 1 of 100 may have one. With 300 features, a rate of 0.01 would rarely give ten.
  const Series series = series_of_signals(300, 40, 1, 4, [](std::size_t, double) { return cv::Point2d(50, 50); });
  std::size_t alarms = 0;
  for (const Rhythms &found : each(series)) alarms += found.rhythms.size();
  EXPECT_LT(alarms, 10u);
  EXPECT_TRUE(together(series).rhythms.empty());
}

TEST(Rhythms, FindsNoneInRedNoise) {
  // Features on random walks, as a hand-held camera makes.
  std::mt19937 random(5);
  std::normal_distribution<double> step(0, .5);
  std::vector<cv::Point2d> at(100, {50, 50});
  const Series series = series_of_signals(
      100, 60, .1, 5, [&](std::size_t f, double) { return at[f] += cv::Point2d(step(random), step(random)); });
  std::size_t alarms = 0;
  for (const Rhythms &found : each(series)) alarms += found.rhythms.size();
  EXPECT_LT(alarms, 6u);
}

TEST(Rhythms, FindsNoneInAStillScene) {
  const Series series = series_of_signals(
      2, 30, 0, 6, [](std::size_t f, double t) { return f == 0 ? cv::Point2d(3, 4) : cv::Point2d(3 + t, 4); });
  for (const Rhythms &found : each(series)) {
    EXPECT_EQ(found.windows, 1u);
    EXPECT_TRUE(found.rhythms.empty());
  }
}

TEST(Rhythms, AWanderingHeartIsOneRhythm) {
  // From 1 Hz to 1.6 Hz in ten minutes: 1 + 0.001 t.
  const Series series = series_of_signals(
      2, 600, .2, 7, [](std::size_t, double t) { return cv::Point2d(2 * sine(t + .0005 * t * t), 3 * sine(.25 * t)); });
  const Rhythms found = together(series);
  ASSERT_EQ(found.rhythms.size(), 2u);
  const Rhythm heart = found.rhythms[1];
  EXPECT_EQ(found.windows, 19u);
  ASSERT_EQ(heart.rates.size(), 19u);
  for (const Rate &rate : heart.rates) EXPECT_NEAR(rate.frequency, 1 + .001 * rate.time, .01);
  EXPECT_NEAR(heart.frequency, 1.3, .01);
  EXPECT_NEAR(heart.amplitude, 2, .2);
}

TEST(Rhythms, AFastMultipleOfASlowRhythmIsNoHarmonicWithoutTheOnesBetween) {
  // Five times as fast, with nothing in between: a heart at 75 and a breath at 15 a minute.
  const Series series = series_of_signals(
      1, 60, .2, 8, [](std::size_t, double t) { return cv::Point2d(sine(1.25 * t + .1), 4 * sine(.25 * t)); });
  const auto found = each(series).front();
  ASSERT_EQ(found.rhythms.size(), 2u);
  EXPECT_TRUE(found.rhythms[0].harmonics.empty());
}

TEST(Rhythms, OfTheSceneNeedAQuarterOfTheFeatures) {
  const auto with = [](std::size_t moving) {
    return series_of_signals(20, 40, .3, 9, [moving](std::size_t f, double t) {
      return cv::Point2d(f < moving ? 3 * sine(1.1 * t) : 0, 2 * sine(.3 * t));
    });
  };
  EXPECT_NEAR(near(together(with(10)), 1.1).frequency, 1.1, .005);
  EXPECT_EQ(near(together(with(2)), 1.1).frequency, 0) << "two of twenty";
  EXPECT_NEAR(near(together(with(2)), .3).frequency, .3, .003);
  const Rhythm all = near(together(with(10)), 1.1);
  EXPECT_LT(all.amplitude_low, .2);
  EXPECT_NEAR(all.amplitude_high, 3, .1);
}

TEST(Rhythms, TooLittleIsNotAnalysed) {
  const Series series = series_of_signals(3, 40, .1, 10, tissue, [](std::size_t f, double t) {
    return f == 0 ? t < 10 : f == 1 ? t > 30 && t < 30.5 : true;
  });
  const auto found = each(series);
  EXPECT_EQ(found[0].windows, 0u) << "less than half of the window";
  EXPECT_EQ(found[1].windows, 0u);
  EXPECT_EQ(found[2].windows, 1u);
  const auto shorter = each(series, {.window = 10});
  EXPECT_GT(shorter[0].windows, 0u);
  EXPECT_NEAR(near(shorter[0], 1.3127).frequency, 1.3127, .02);
}

TEST(Rhythms, AcceptsOneFrameAndDistantOnes) {
  Series series;
  series.times = {5};
  series.frames = {0};
  series.paths.push_back({0, {0}, {{1, 2}}});
  EXPECT_EQ(each(series).front().windows, 0u);
  // Thirty frames, and thirty years later thirty more.
  series = {};
  for (std::size_t i = 0; i < 60; ++i) {
    series.times.push_back(static_cast<double>(i) * .04 + (i < 30 ? 0 : 1e9));
    series.frames.push_back(i);
  }
  series.interval = .04;
  series.paths.push_back({0, series.frames, std::vector<cv::Point2d>(60, {1, 2})});
  EXPECT_EQ(each(series).front().rhythms.size(), 0u);
}

TEST(Rhythms, RespectsTheBandAndReportsProgress) {
  const Series series = series_of_signals(1, 60, .2, 11, tissue);
  unsigned rounds = 0;
  double share = 0;
  const auto found = each(series, {.lowest = .6, .highest = 2, .progress = [&](unsigned round, double s) {
                                     rounds = std::max(rounds, round);
                                     share = s;
                                   }});
  ASSERT_EQ(found[0].rhythms.size(), 1u);
  EXPECT_NEAR(found[0].rhythms[0].frequency, 1.3127, .003);
  EXPECT_TRUE(found[0].rhythms[0].harmonics.empty());
  EXPECT_GE(rounds, 1u);
  EXPECT_EQ(share, 1);
}

TEST(UsualName, IsByBand) {
  EXPECT_EQ(usual_name(.09), "");
  EXPECT_EQ(usual_name(.1), "breath");
  EXPECT_EQ(usual_name(.6), "heart");
  EXPECT_EQ(usual_name(3.5), "heart");
  EXPECT_EQ(usual_name(3.6), "");
}

TEST(SameRate, ComparesCommonWindows) {
  Rhythm a, b;
  a.frequency = 2.4;
  b.frequency = 1.2;
  EXPECT_TRUE(same_rate(a, b, 2, 60));
  EXPECT_FALSE(same_rate(a, b, 1, 60));
  b.frequency = 1.26;  // twice 0.06 off; 2 % of 2.4 are 0.048
  EXPECT_FALSE(same_rate(a, b, 2, 60));
  // They agree in their common windows.
  a.rates = {{0, 2.4}, {30, 2.6}, {60, 2.8}};
  b.rates = {{30, 1.3}, {60, 1.4}, {90, 1.5}};
  EXPECT_TRUE(same_rate(a, b, 2, 60));
}

}  // namespace
}  // namespace csd::motion
