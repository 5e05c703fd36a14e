// SPDX-License-Identifier: LGPL-2.1-or-later
#include "motion/peaks.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace csd::motion {
namespace {

// Windows of 60 s, 0.05…4 Hz.
constexpr Grid grid{1. / 120, 6, 475};

/// Noise of one feature with mean 0.002, plus peaks in the shape of Hann's: {Hz, height}.
std::vector<float> spectrum_of(std::mt19937 &random, const std::vector<std::pair<double, double>> &peaks) {
  std::exponential_distribution<double> power(500);
  std::vector<float> spectrum(grid.count);
  for (std::size_t i = 0; i < grid.count; ++i) {
    double value = power(random);
    for (const auto &[frequency, height] : peaks) {
      const double off = (grid.frequency(static_cast<double>(i)) - frequency) * 60;
      value += height * std::exp(-off * off / .75);
    }
    spectrum[i] = static_cast<float>(value);
  }
  return spectrum;
}

/// The search of one feature whose ellipses are given, so that peaks can be removed completely.
class Bench {
 public:
  explicit Bench(std::size_t windows) : search(windows, grid, .01), windows_(windows) {}

  /// Window w has the peaks `peaks_of(w)`. A proposed peak leaves no remainder.
  template <typename PeaksOf>
  int run(PeaksOf peaks_of) {
    int rounds = 0;
    for (; search.active() && rounds < 50; ++rounds) {
      std::mt19937 random(5);
      for (std::size_t w = 0; w < windows_; ++w) {
        View &view = search.view(w);
        view.members = {0};
        view.missing = {0};
        view.whole = view.remainder = view.dimensions = {1};
        auto there = peaks_of(w);
        view.ellipses.clear();
        for (const double found : search.frequencies(w)) {
          double height = 0;
          for (auto &[frequency, h] : there)
            if (std::abs(frequency - found) < .01) {
              height += h;
              h = 0;
            }
          view.ellipses.push_back({{std::sqrt(2 * height), 0, 0, 0}});
        }
        view.spectrum = spectrum_of(random, there);
      }
      search.search();
    }
    return rounds;
  }

  PeakSearch search;

 private:
  std::size_t windows_;
};

using Peaks = std::vector<std::pair<double, double>>;

TEST(PeakSearch, FindsPeaksBetweenFrequencies) {
  Bench bench(3);
  bench.run([](std::size_t) { return Peaks{{.2517, .6}, {1.1031, .3}}; });
  ASSERT_EQ(bench.search.peaks().size(), 2u);
  EXPECT_NEAR(bench.search.peaks()[0].frequency, .2517, .0005);
  EXPECT_NEAR(bench.search.peaks()[1].frequency, 1.1031, .0005);
  for (const Peak &peak : bench.search.peaks()) EXPECT_LT(peak.false_alarm, 1e-9);
}

TEST(PeakSearch, FindsNoneInNoise) {
  Bench bench(1);
  EXPECT_LT(bench.run([](std::size_t) { return Peaks{}; }), 10);
  EXPECT_TRUE(bench.search.peaks().empty());
}

TEST(PeakSearch, FollowsAChangingRate) {
  // From 0.9 to 1.8 Hz in twenty windows: no window shows more than its neighbours do, and the mean has no single peak.
  const auto rate = [](std::size_t w) { return .9 * std::pow(2, static_cast<double>(w) / 19); };
  Bench bench(20);
  bench.run([&](std::size_t w) { return Peaks{{rate(w), .5}}; });
  ASSERT_EQ(bench.search.peaks().size(), 1u);
  const Peak &peak = bench.search.peaks()[0];
  for (std::size_t w = 0; w < 20; ++w) {
    EXPECT_TRUE(peak.stands_out[w]) << w;
    EXPECT_NEAR(peak.by_window[w], rate(w), .001) << w;
  }
  EXPECT_NEAR(peak.frequency, (rate(9) + rate(10)) / 2, .001) << "the median";
}

TEST(PeakSearch, KeepsTheRateWhereItIsNotVisible) {
  Bench bench(9);
  bench.run([&](std::size_t w) { return w == 4 ? Peaks{} : Peaks{{1.2, .5}}; });
  ASSERT_EQ(bench.search.peaks().size(), 1u);
  EXPECT_FALSE(bench.search.peaks()[0].stands_out[4]);
  EXPECT_NEAR(bench.search.peaks()[0].by_window[4], 1.2, .001);
}

TEST(PeakSearch, DropsAPeakThatTheFitDoesNotConfirm) {
  // A spectral peak without an ellipse, as a gap makes: the fit gives it no amplitude.
  PeakSearch search(1, grid, .01);
  for (int round = 0; search.active(); ++round) {
    ASSERT_LT(round, 10);
    std::mt19937 random(6);
    View &view = search.view(0);
    view.members = {0};
    view.missing = {0};
    view.whole = view.remainder = view.dimensions = {1};
    view.ellipses.assign(search.frequencies(0).size(), {{.001, 0, 0, 0}});
    view.spectrum = spectrum_of(random, round == 0 ? Peaks{{1.5, .4}} : Peaks{});
    search.search();
    if (round == 0) {
      ASSERT_EQ(search.peaks().size(), 1u);
    }
  }
  EXPECT_TRUE(search.peaks().empty());
}

TEST(PeakSearch, CombinesFeaturesByTheUpperQuartile) {
  PeakSearch search(1, grid, .01);
  View &view = search.view(0);
  view.members = {0, 1, 2, 3, 4};
  view.whole = {1, 1, 4, 1, 0};
  view.remainder = {1, 1, 2, 1, 0};
  Eigen::MatrixXf power = Eigen::MatrixXf::Zero(6, static_cast<Eigen::Index>(grid.count));
  power.col(3) << 9, .1F, .2F, .3F, .9F, .5F;  // the first row is another feature's
  search.combine(0, power, 1);
  // .1, .2, .3 · ½, .9, and 0 of the still feature: 0, .1, .15, .2, .9.
  EXPECT_FLOAT_EQ(view.spectrum[3], .2F);
  EXPECT_EQ(view.spectrum[4], 0);
}

}  // namespace
}  // namespace csd::motion
