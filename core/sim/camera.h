// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <opencv2/core.hpp>

#include <cstdint>

#include "sim/scenario.h"

namespace csd::sim {

/// Lengths in the scene are in units: a picture shows 480 units from top to bottom at `nominal_distance`, so before
/// anything moves a unit is a pixel of a 640×480 picture. x points right, y down, z from the tissue (z ≈ 0) to the
/// scope.
inline constexpr double nominal_distance = 600;
inline constexpr double units_high = 480;

/// A pinhole camera that looks at the tissue, with the lamp beside it.
struct Camera {
  cv::Vec3d centre;
  cv::Vec3d right, down, forward;  ///< axes of the picture in scene coordinates; orthonormal
  double focal = 0;                ///< pixels
  cv::Point2d principal;           ///< pixels, centres at integers
  double distance = 0;             ///< to the point at the centre of view
  double magnification = 1;        ///< pixels per unit there

  /// Projects a point to picture coordinates (pixels) and depth (units along the axis; ≤ 0: behind the camera).
  cv::Point3d project(const cv::Vec3d &p) const {
    const cv::Vec3d d = p - centre;
    const double z = d.dot(forward), scale = focal / z;
    return {principal.x + scale * d.dot(right), principal.y + scale * d.dot(down), z};
  }

  /// Intersects a pixel's ray with the plane z = 0, at any angle (rays that don't descend are clipped).
  cv::Point2d to_plane(cv::Point2d pixel) const;
};

/// The camera `time` seconds after the start, for a picture of `size`. Depends only on its arguments.
Camera camera_at(double time, const Effects &effects, std::uint64_t seed, cv::Size size);

/// The effects zoom and rotation: magnification (0.66…2.8 at strength 1) and roll (turns).
double zoom_at(double time, double strength);
double roll_at(double time, double strength);

}  // namespace csd::sim
