// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <functional>
#include <string_view>
#include <vector>

#include "motion/series.h"

namespace csd::motion {

struct SearchOptions {
  double window = 60;         ///< s; a shorter recording is one window
  double lowest = 0.05;       ///< Hz; at least 2.5 periods fit into a window
  double highest = 4;         ///< Hz; at most 0.4 of the frame rate
  double false_alarm = 0.01;  ///< the greatest false-alarm probability that is reported
  /// Told now and then how far the search is: the round (from 0; nobody knows how many there will be), and its share.
  std::function<void(unsigned round, double share)> progress = {};
};

/// A sinusoid whose frequency is a multiple of a rhythm's: the two are one movement that isn't sinusoidal.
struct Harmonic {
  unsigned multiple = 2;
  double frequency = 0;  ///< Hz, as found
  double amplitude = 0;  ///< px, as Rhythm::amplitude
};

/// The rate in one window.
struct Rate {
  double time = 0;       ///< s, the window's middle
  double frequency = 0;  ///< Hz
};

struct Rhythm {
  double frequency = 0;  ///< Hz; the median of `rates` if these are at least three
  /// px, from the middle to the end of the path: the semi-major axis of the ellipse that the fundamental moves along.
  /// The median over windows, then over features, with their quartiles. Peak to peak is twice that.
  double amplitude = 0, amplitude_low = 0, amplitude_high = 0;
  double direction = 0;    ///< degrees, −90 < d ≤ 90: of the ellipse's long axis from the picture's x to its y
  double explained = 0;    ///< 0…1: share of the variance (drift left out) that fundamental and harmonics make up
  double false_alarm = 1;  ///< 0…1: probability that noise alone shows such a peak anywhere
  std::vector<Harmonic> harmonics;
  std::vector<Rate> rates;  ///< of the windows in which the rhythm stands out by itself

  double period() const { return 1 / frequency; }
};

/// "breath" 0.1–0.6 Hz, "heart" 0.6–3.5 Hz, else "": what a rhythm of that rate usually is. No more than a name.
std::string_view usual_name(double frequency);

/// Whether `a` may be `multiple` times the rhythm `b`: by the windows in which both stand out, else by their
/// frequencies.
bool same_rate(const Rhythm &a, const Rhythm &b, unsigned multiple, double window);

/// What was found in some features together.
struct Rhythms {
  std::vector<Rhythm> rhythms;  ///< by `explained`, the greatest first
  std::size_t windows = 0;      ///< in which there was enough to look at
};

/// Looks for rhythms in each group of features (indices into Series::paths) by itself; the result is one for each
/// group.
///
/// In windows that overlap by half: drift is taken out, then a generalised Lomb–Scargle periodogram made of each
/// feature; of a window that is the upper quartile over the group's features, so that a rhythm of a quarter of them is
/// seen and what fewer do isn't; over windows the mean (Welch 1967). Peaks that noise at the level around them explains
/// with a probability above `false_alarm` are none. Peaks that are found are taken out, in each window at the rate that
/// it has there, and the search goes on, so that gaps in strong rhythms don't look like others.
std::vector<Rhythms> find_rhythms(const Series &series, const std::vector<std::vector<std::size_t>> &groups,
                                  const SearchOptions &options = {});

}  // namespace csd::motion
