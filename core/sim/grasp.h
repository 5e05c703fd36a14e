// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <opencv2/core.hpp>

#include <cstdint>

namespace csd::sim {

/// The state of an instrument that grasps the tissue, pulls, and lets go. Every five seconds it comes to another place
/// near the middle; the tissue is at rest until 0.7 s and between two pulls.
struct Grasp {
  cv::Point2d hold;         ///< the point of the surface that it grasps, units
  cv::Vec3d pull{0, 0, 0};  ///< displacement of that point, units
  double sigma = 1;         ///< units in which the pull falls off to 1/e; longer than `pull`, so that nothing folds
  double in = 0;            ///< 0…1: how far the instrument is inserted
  double open = 0;          ///< 0…1: opening of its jaws
  cv::Point2d port{0, 0};   ///< its entry point, as fractions of the picture's width and height
  bool coloured = false;

  /// The displacement of a point (units).
  cv::Vec3d at(double u, double v) const;
};

Grasp grasp_at(double time, double strength, std::uint64_t seed);

/// Upper bound of any point's sideways displacement, units.
double grasp_reach(double strength);

}  // namespace csd::sim
