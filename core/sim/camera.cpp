// SPDX-License-Identifier: LGPL-2.1-or-later
#include "sim/camera.h"

#include <algorithm>

#include "sim/events.h"
#include "sim/ieee_math.h"

namespace csd::sim {
namespace {

constexpr std::uint64_t stream_sway = 100, stream_jerk = 110, stream_black = 120;
constexpr double base_tilt = 0.035;                            // turns: tissue is rarely seen straight from above
constexpr double farthest_hollow = 0.7, nearest_hollow = 1.6;  // zoom; beyond these the ends of the walls would show
constexpr double min_descent = 0.15;

/// A curve through (phase, value) points, with zero slope at each; `phase` in 0…1.
template <std::size_t N>
double through(const double (&points)[N][2], double phase) {
  for (std::size_t i = 1; i < N; ++i) {
    if (phase < points[i][0]) {
      const double f = (phase - points[i - 1][0]) / (points[i][0] - points[i - 1][0]);
      return lerp(points[i - 1][1], points[i][1], smoothstep(f));
    }
  }
  return points[N - 1][1];
}

double cycle(double time) {
  const double c = time / cycle_seconds;
  return c - floor_of(c);
}

/// Sudden moves: every few seconds to a new random value, within a fraction of a second.
double jerked(double time, std::uint64_t seed, std::uint64_t axis) {
  constexpr double every = 2.7;
  const double k = floor_of(time / every);
  const auto i = static_cast<std::int64_t>(k);
  const auto value = [&](std::int64_t n) { return n <= 0 ? 0.0 : 2 * hashed(seed, stream_jerk + axis, n) - 1; };
  const double takes = 0.12 + 0.25 * hashed(seed, stream_jerk + 9, i);
  return lerp(value(i - 1), value(i), smoothstep((time - k * every) / takes));
}

}  // namespace

double zoom_at(double time, double strength) {
  constexpr double near = 1.4854268271702415, far = -0.5994620704162712;  // log₂ of 2.8 and of 0.66
  static constexpr double path[][2] = {{0, 0}, {0.05, 0}, {0.35, near}, {0.45, near}, {0.75, far}, {0.83, far}, {1, 0}};
  return exp_of(strength * 0.69314718055994531 * through(path, cycle(time)));
}

double roll_at(double time, double strength) {
  static constexpr double path[][2] = {
      {0, 0}, {0.05, 0}, {0.4, 120.0 / 360}, {0.48, 120.0 / 360}, {0.85, -50.0 / 360}, {0.9, -50.0 / 360}, {1, 0}};
  return strength * through(path, cycle(time));
}

Camera camera_at(double time, const Effects &effects, std::uint64_t seed, cv::Size size) {
  const double sway = effects[Effect::sway], jerk = effects[Effect::jerk], hollow = effects[Effect::cavity];
  cv::Vec3d target{0, 0, 0};
  double tilt_x = base_tilt, tilt_y = 0, roll = roll_at(time, effects[Effect::rotation]);
  double zoom = zoom_at(time, effects[Effect::zoom]);

  if (hollow > 0) {
    // Back and forth along the axis, and sideways.
    const double begun = std::min(hollow, 1.5) * smoothstep(time / 1.5);
    zoom *= 1 + 0.24 * begun * sin_turns(time / 7.3);
    target[0] += 36 * begun * sin_turns(time / 10.7);
    target[1] += 26 * begun * sin_turns(time / 6.1);
    tilt_x -= 0.6 * base_tilt * std::min(hollow, 1.0);
  }
  if (sway > 0) {
    const auto drift = [&](std::uint64_t axis) {
      // A slow drift plus hand tremor. Both start from rest, because features are chosen in the first frame.
      const double slow = wander(seed, stream_sway + axis, time / 2.3);
      const double fast = wander(seed, stream_sway + 5 + axis, time * 4);
      return sway * smoothstep(time / 2) * (slow + 0.05 * fast);
    };
    target[0] += 38 * drift(0);
    target[1] += 30 * drift(1);
    tilt_x += 0.015 * drift(2);
    tilt_y += 0.015 * drift(3);
    roll += 0.01 * drift(4);
  }
  if (jerk > 0) {
    target[0] += 55 * jerk * jerked(time, seed, 0);
    target[1] += 40 * jerk * jerked(time, seed, 1);
    roll += 0.02 * jerk * jerked(time, seed, 2);
    zoom *= 1 + std::min(0.08 * jerk, 0.3) * jerked(time, seed, 3);
  }
  if (effects[Effect::black] > 0) {
    // During a blackout the view moves on, each time to another place near the first.
    const BlackOut black = black_out(time, effects[Effect::black]);
    const auto place = [&](std::uint64_t axis, std::int64_t n) {
      return n < 0 ? 0.0 : 2 * hashed(seed, stream_black + axis, n) - 1;
    };
    for (int axis = 0; axis < 2; ++axis) {
      const auto a = static_cast<std::uint64_t>(axis);
      target[axis] += 50 * lerp(place(a, black.index - 1), place(a, black.index), black.moved);
    }
    roll += 0.03 * lerp(place(2, black.index - 1), place(2, black.index), black.moved);
  }

  if (hollow > 0) zoom = std::clamp(zoom, farthest_hollow, nearest_hollow);

  Camera c;
  const double cx = cos_turns(tilt_x), sx = sin_turns(tilt_x), cy = cos_turns(tilt_y), sy = sin_turns(tilt_y);
  const double cr = cos_turns(roll), sr = sin_turns(roll);
  // Tilts about the picture's x, then its y, then rolls about the axis.
  const cv::Vec3d forward{-sy * cx, -sx, -cy * cx}, right0{cy, 0, -sy};
  const cv::Vec3d down0 = right0.cross(forward);
  c.forward = forward;
  c.right = cr * right0 - sr * down0;
  c.down = sr * right0 + cr * down0;
  c.distance = nominal_distance / zoom;
  c.centre = target - c.distance * forward;
  c.focal = nominal_distance * size.height / units_high;
  c.principal = {(size.width - 1) * 0.5, (size.height - 1) * 0.5};
  c.magnification = c.focal / c.distance;
  return c;
}

cv::Point2d Camera::to_plane(cv::Point2d pixel) const {
  const cv::Vec3d ray = forward + right * ((pixel.x - principal.x) / focal) + down * ((pixel.y - principal.y) / focal);
  const double s = centre[2] / std::max(-ray[2], min_descent);
  return {centre[0] + s * ray[0], centre[1] + s * ray[1]};
}

}  // namespace csd::sim
