// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "sim/ieee_math.h"

/// Times of events, in seconds from the start. Everything is a function of time, so frames can be rendered in any
/// order.
namespace csd::sim {

inline constexpr double cycle_seconds = 20;  ///< of zoom, rotation, smoke and all repeating events

/// 0…1: the presence of something that lasts from `begin` to `end` of each cycle.
inline double each_cycle(double time, double begin, double rise, double end, double fall) {
  return window(time - cycle_seconds * floor_of(time / cycle_seconds), begin, rise, end, fall);
}

/// Two bursts in each cycle, 0…1.
inline double smoke_density(double time) {
  return each_cycle(time, 2.5, 1.5, 8, 3) + 0.85 * each_cycle(time, 11.5, 1, 18, 4);
}

/// Another scene shows 4…6 s and 13…14.5 s into each cycle.
inline bool is_cut(double time) {
  const double t = time - cycle_seconds * floor_of(time / cycle_seconds);
  return (t >= 4 && t < 6) || (t >= 13 && t < 14.5);
}

struct BlackOut {
  std::int64_t index = -1;  ///< the last one that has begun; −1: none
  bool dark = false;        ///< whether it is dark now
  double moved = 0;         ///< 0…1: progress of the view's move since it began
};

/// Black for 2.5·√strength s, first after 6 s, then in each cycle.
inline BlackOut black_out(double time, double strength) {
  constexpr double first = 6;
  const double length = 2.5 * std::sqrt(strength), k = floor_of((time - first) / cycle_seconds);
  if (k < 0) return {};
  const double since = time - first - k * cycle_seconds;
  return {static_cast<std::int64_t>(k), since < length, smoothstep(since / length)};
}

/// 0…1 with `progress`, in six uneven steps, like tissue under tension: it creeps, then slips. The three numbers
/// determine the step sizes.
inline double stick_slip(double progress, std::uint64_t seed, std::uint64_t stream, std::int64_t index) {
  constexpr int steps = 6;
  const auto size = [&](int i) { return 0.4 + 1.2 * hashed(seed, stream, steps * index + i); };
  double all = 0, done = 0;
  for (int i = 0; i < steps; ++i) all += size(i);
  const double at = steps * clamp01(progress);
  for (int i = 0; i < steps && i < at; ++i) {
    const double x = std::min(at - i, 1.0);
    done += size(i) * (0.2 * x + 0.8 * smoothstep((x - 0.75) / 0.25));
  }
  return done / all;
}

struct Wipe {
  double cover = -1;  ///< centre of the cloth, 0…1 across the picture; outside −0.5…1.5 there is none
  double smear = 0;   ///< 0…1: blur of the picture
};

/// 5 s and 15 s into each cycle a cloth passes in 0.6 s and leaves a wet lens that clears in 1.5 s.
inline Wipe wipe_at(double time) {
  const double t = time - 10 * floor_of(time / 10) - 5;
  if (t < 0 || t > 2.2) return {};
  return {t / 0.6 * 2 - 0.5, window(t, 0, 0.3, 2.2, 1.5)};
}

}  // namespace csd::sim
