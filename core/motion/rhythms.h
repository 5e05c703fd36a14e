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
  double false_alarm = 0.01;  ///< largest false-alarm probability to report
  /// Called now and then with the search's progress: the round (from 0; their number is unknown), and the share done.
  std::function<void(unsigned round, double share)> progress = {};
};

/// A sinusoid at a multiple of a rhythm's frequency: together they are one non-sinusoidal movement.
struct Harmonic {
  unsigned multiple = 2;
  double frequency = 0;  ///< Hz, as detected
  double amplitude = 0;  ///< px, as Rhythm::amplitude
};

/// The rate in one window.
struct Rate {
  double time = 0;       ///< s, the window's middle
  double frequency = 0;  ///< Hz
};

struct Rhythm {
  double frequency = 0;  ///< Hz; the median of `rates` if at least three
  /// px, from the centre of the motion to its end: the semi-major axis of the fundamental's ellipse. The median over
  /// windows, then over features, with their quartiles. Peak to peak is twice that.
  double amplitude = 0, amplitude_low = 0, amplitude_high = 0;
  double direction = 0;    ///< degrees, −90 < d ≤ 90: of the ellipse's long axis, from the picture's x to its y
  double explained = 0;    ///< 0…1: share of the variance without drift in the fundamental and harmonics
  double false_alarm = 1;  ///< 0…1: probability that noise alone gives such a peak anywhere
  std::vector<Harmonic> harmonics;
  std::vector<Rate> rates;  ///< of the windows in which the rhythm stands out itself

  double period() const { return 1 / frequency; }
};

/// "breath" 0.1–0.6 Hz, "heart" 0.6–3.5 Hz, else "": what a rhythm of that rate usually is. Only a name.
std::string_view usual_name(double frequency);

/// Whether `a` may be `multiple` times the rhythm `b`: from the windows in which both stand out, else from their
/// frequencies.
bool same_rate(const Rhythm &a, const Rhythm &b, unsigned multiple, double window);

/// The rhythms of some features.
struct Rhythms {
  std::vector<Rhythm> rhythms;  ///< by `explained`, the largest first
  std::size_t windows = 0;      ///< with enough data
};

/// Finds the rhythms of each group of features (indices into Series::paths) independently; returns one result per
/// group.
///
/// Windows overlap by half. In each, it removes drift and computes a generalised Lomb–Scargle periodogram per feature,
/// then the upper quartile over the group's features: a rhythm shared by a quarter of them shows, one of fewer doesn't.
/// Over windows it takes the mean (Welch 1967). It rejects peaks that noise at the surrounding level explains with a
/// probability above `false_alarm`. It removes accepted peaks, in each window at the rate they have there, and searches
/// again, so that the effect of gaps on strong rhythms isn't taken for other rhythms.
std::vector<Rhythms> find_rhythms(const Series &series, const std::vector<std::vector<std::size_t>> &groups,
                                  const SearchOptions &options = {});

}  // namespace csd::motion
