// SPDX-License-Identifier: LGPL-2.1-or-later
#include "sim/fluids.h"

#include <algorithm>
#include <cmath>

#include "sim/events.h"
#include "sim/ieee_math.h"

namespace csd::sim {
namespace {

constexpr std::uint64_t stream_place = 400, stream_edge = 401;

// Seconds into each cycle: the places bleed one after another, then water runs over all of them together, then they are
// wiped one after another.
constexpr double bleeds = 3, next_bleeds = 1.5, oozes = 5, rinsed = 11, rinsing = 3.5, wiped = 13, next_wiped = 1,
                 wiping = 2;
constexpr double edge = 7, soft_edge = 22;  // units

/// Smooth noise in the plane, −1…1, about one independent value per unit.
double noise(std::uint64_t seed, double x, double y) {
  const double kx = floor_of(x), ky = floor_of(y);
  const auto at = [&](int i, int j) {
    return hashed(seed, stream_edge,
                  (static_cast<std::int64_t>(kx) + i) * 7919 + (static_cast<std::int64_t>(ky) + j) * 104729);
  };
  const double fx = smoothstep(x - kx), fy = smoothstep(y - ky);
  return 2 * lerp(lerp(at(0, 0), at(1, 0), fx), lerp(at(0, 1), at(1, 1), fx), fy) - 1;
}

}  // namespace

Fluids::Fluids(const Effects &effects, std::uint64_t seed)
    : blood_(effects[Effect::blood]), water_(effects[Effect::irrigation]), seed_(seed) {
  radius_ = 125 * std::sqrt(std::max(blood_, water_));
  Random random(seed, stream_place);
  for (std::size_t i = 0; i < places_.size(); ++i) {
    // One in each quarter of the picture.
    const double side = i % 2 == 0 ? -1 : 1, height = i == 0 || i == 3 ? -1 : 1;
    places_[i] = {side * random.uniform(40, 150), height * random.uniform(20, 110)};
  }
}

void Fluids::wet(double time, double u, double v, Fragment &corner) const {
  double blood = -10, water = -10, changed = -10;
  const double t = time - cycle_seconds * floor_of(time / cycle_seconds);
  const double flows = water_ > 0 ? window(t, rinsed, 0.6, rinsed + rinsing, 1.2) : 0;
  for (std::size_t i = 0; i < places_.size(); ++i) {
    const double du = u - places_[i].u, dv = v - places_[i].v, r = std::sqrt(du * du + dv * dv);
    if (r > 2 * radius_) continue;
    // The radius of the place in this direction, units; its edge is ragged.
    const double inside =
        radius_ * (1 + 0.35 * noise(seed_ + i, u / 55, v / 55) + 0.1 * noise(seed_ + i, u / 17, v / 17));
    // Wiping and rinsing go from top to bottom.
    const auto turn = static_cast<double>(i);
    const double begin = blood_ > 0 ? wiped + next_wiped * turn : rinsed, takes = blood_ > 0 ? wiping : rinsing;
    const double front = lerp(-1.6, 1.6, clamp01((t - begin) / takes)) * radius_;
    const double clean = t < begin ? -1e3 : front - dv;  // > 0: already wiped
    if (blood_ > 0) {
      const double spread = smoothstep((t - bleeds - next_bleeds * turn) / oozes);
      if (spread > 0) blood = std::max(blood, std::min(inside * spread - r, -clean) / edge);
    }
    if (flows > 0) water = std::max(water, std::min(1.35 * inside * flows - r, 60.0) / (2 * edge));
    // The first time changes its look permanently.
    changed = std::max(changed, std::min(0.95 * inside - r, time < cycle_seconds ? clean : 1e3) / soft_edge);
  }
  corner[Fragment::blood] = static_cast<float>(std::clamp(blood, -2.0, 2.0));
  corner[Fragment::water] = static_cast<float>(std::clamp(water, -2.0, 2.0));
  corner[Fragment::changed] = static_cast<float>(std::clamp(changed, -2.0, 2.0));
}

}  // namespace csd::sim
