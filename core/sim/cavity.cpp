// SPDX-License-Identifier: LGPL-2.1-or-later
#include "sim/cavity.h"

#include <algorithm>
#include <cmath>

#include "sim/camera.h"
#include "sim/ieee_math.h"

namespace csd::sim {
namespace {

// Depth is `nearest` + `farther` at radius 0, half a `farther` less at `half_radius`. At strength 1 it is 2.1 on the
// axis, due to `blunt`, and 0.6 in the picture's corners.
constexpr double nearest = 0.25, farther = 2.35, half_radius = 70, blunt = 20;
constexpr double deepest = 1.15;  // strength limit; more would put the walls behind the scope

// Each ring is 1.8 times as far out as the one before, so they are evenly spaced along the tube.
constexpr double spacing_log2 = 0.84799690655495, ring_height = 0.22, innermost = 35, fully = 140;
constexpr double turning = 0.37;  // turns from one ring to the next

double softened(double u, double v) {
  return std::sqrt(u * u + v * v + blunt * blunt);
}

}  // namespace

double Cavity::depth(double radius) const {
  const double full = nearest + farther / (1 + radius / half_radius);
  return 1 + std::min(strength_, deepest) * (full - 1);
}

cv::Vec3d Cavity::at(double u, double v, double relief) const {
  const double radius = softened(u, v), far = depth(radius);
  const double c = u / radius, s = v / radius;
  // Not circular, and crescents rather than rings: each is highest on another side than its neighbours.
  const double at = log2_of(radius / 230) * (1 / spacing_log2) + 0.14 * c + 0.1 * 2 * s * c + 0.006 * relief;
  const double side = c * cos_turns(turning * at) + s * sin_turns(turning * at);
  const double height = std::min(strength_, deepest) * ring_height * (0.62 + 0.38 * side) *
                        smoothstep((radius - innermost) / (fully - innermost));
  const double narrowed = 1 - height * (0.5 + 0.5 * cos_turns(at)) - relief / 500 * clamp01(strength_);
  return {u * far * narrowed, v * far * narrowed, nominal_distance * (1 - far) + relief * (1 - clamp01(strength_))};
}

double Cavity::facing(double u, double v) const {
  // The angle between the ray and the wall's curve (radius·depth, depth).
  const double radius = softened(u, v), far = depth(radius), step = 0.5;
  const double slope = (depth(radius + step) - depth(radius - step)) / (2 * step);
  const cv::Vec2d wall(far + radius * slope, nominal_distance * slope), ray(radius, nominal_distance);
  return std::abs(wall[0] * ray[1] - wall[1] * ray[0]) / std::sqrt(wall.dot(wall) * ray.dot(ray));
}

double Cavity::reach() const {
  return any() ? (0.25 + std::min(strength_, deepest)) * 240 : 0;
}

}  // namespace csd::sim
