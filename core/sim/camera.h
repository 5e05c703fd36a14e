// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <opencv2/core.hpp>

#include <cstdint>

#include "sim/scenario.h"

namespace csd::sim {

/// Lengths in the scene are units: a picture shows 480 units from top to bottom, seen from `nominal_distance`. A unit
/// is so a pixel of a 640×480 picture before anything moves. x points right, y down, z from the tissue (z ≈ 0) to the
/// scope.
inline constexpr double nominal_distance = 600;
inline constexpr double units_high = 480;

/// A pinhole that looks at the tissue; the lamp sits beside it.
struct Camera {
  cv::Vec3d centre;
  cv::Vec3d right, down, forward;  ///< of the picture, in the scene; orthonormal
  double focal = 0;                ///< pixels
  cv::Point2d principal;           ///< pixels, centres at integers
  double distance = 0;             ///< to the point that it looks at
  double magnification = 1;        ///< pixels per unit there

  /// Where a point is in the picture (pixels) and how deep (units along the axis; ≤ 0: behind the camera).
  cv::Point3d project(const cv::Vec3d &p) const {
    const cv::Vec3d d = p - centre;
    const double z = d.dot(forward), scale = focal / z;
    return {principal.x + scale * d.dot(right), principal.y + scale * d.dot(down), z};
  }

  /// Where the ray of a pixel meets the plane z = 0, whatever the angle (rays that don't descend are cut off).
  cv::Point2d to_plane(cv::Point2d pixel) const;
};

/// The camera `time` seconds after the start, for a picture of `size`: a function of its arguments alone.
Camera camera_at(double time, const Effects &effects, std::uint64_t seed, cv::Size size);

/// How the scope magnifies (0.66…2.8 at strength 1) and rolls (turns) by the effects zoom and rotation.
double zoom_at(double time, double strength);
double roll_at(double time, double strength);

}  // namespace csd::sim
