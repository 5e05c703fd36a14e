// SPDX-License-Identifier: LGPL-2.1-or-later
#include "image/warps.h"

#include <cmath>
#include <numbers>

namespace csd {
namespace {

double radians(double degrees) {
  return degrees * std::numbers::pi / 180;
}

}  // namespace

Warp rotation_warp(double degrees) {
  const double c = std::cos(radians(degrees)), s = std::sin(radians(degrees));
  return {c, -s, 0, s, c, 0, 0, 0, 1};
}

Warp scale_warp(double magnification) {
  return {1 / magnification, 0, 0, 0, 1 / magnification, 0, 0, 0, 1};
}

Warp tilt_warp(double degrees, int axis, int side) {
  // With the camera at distance d, the point p on the rotated axis of the plane is at (p cos, p sin) in (image, depth)
  // and projects to u = d p cos / (d + p sin). The point q on the rotation axis projects to v = d q / (d + p sin).
  // Solved for p and q: p = u / (cos − u sin / d),  q = v cos / (cos − u sin / d). The matrix is divided by cos, so
  // that its last entry is 1.
  const double c = std::cos(radians(degrees)), t = std::tan(radians(degrees)) / (camera_distance * side);
  if (axis == 0) return {1, 0, 0, 0, 1 / c, 0, 0, -t, 1};
  return {1 / c, 0, 0, 0, 1, 0, -t, 0, 1};
}

std::vector<Warp> geometric_warps(int side) {
  std::vector<Warp> warps;
  const int rotations = static_cast<int>(2 * rotation_limit / rotation_step) + 1;
  warps.reserve(static_cast<std::size_t>(rotations + scale_steps) + 2 * std::size(tilts));
  for (int i = 0; i < rotations; ++i) warps.push_back(rotation_warp(-rotation_limit + i * rotation_step));
  for (int i = 0; i < scale_steps; ++i)
    warps.push_back(scale_warp(smallest_scale *
                               std::pow(largest_scale / smallest_scale, static_cast<double>(i) / (scale_steps - 1))));
  for (const double tilt : tilts)
    for (const int axis : {0, 1}) warps.push_back(tilt_warp(tilt, axis, side));
  return warps;
}

}  // namespace csd
