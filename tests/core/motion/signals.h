// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <cmath>
#include <functional>
#include <numbers>
#include <random>

#include "motion/series.h"

namespace csd::motion {

inline double sine(double turns) {
  return std::sin(2 * std::numbers::pi * turns);
}

/// Features that move as `position(feature, time)` says and are claimed where `claimed` says, with noise of `sigma` px.
/// The times differ from 25 frames a second by up to 4 ms.
inline Series series_of_signals(
    std::size_t features, double seconds, double sigma, unsigned seed,
    const std::function<cv::Point2d(std::size_t, double)> &position,
    const std::function<bool(std::size_t, double)> &claimed = [](std::size_t, double) { return true; }) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> jitter(-.004, .004);
  std::normal_distribution<double> noise(0, 1);
  Series series;
  series.interval = .04;
  series.paths.resize(features);
  for (std::size_t f = 0; f < features; ++f) series.paths[f].id = static_cast<FeatureId>(f);
  for (std::size_t i = 0; static_cast<double>(i) * .04 < seconds; ++i) {
    const double time = static_cast<double>(i) * .04 + jitter(random);
    series.times.push_back(time);
    series.frames.push_back(i);
    for (std::size_t f = 0; f < features; ++f) {
      if (!claimed(f, time)) continue;
      const cv::Point2d p = position(f, time), error(noise(random), noise(random));
      series.paths[f].frames.push_back(i);
      series.paths[f].positions.push_back(p + sigma * error);
    }
  }
  return series;
}

}  // namespace csd::motion
