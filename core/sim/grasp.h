// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <opencv2/core.hpp>

#include <cstdint>

namespace csd::sim {

/// An instrument that takes hold of the tissue, pulls, and lets go, at one moment. Every five seconds it comes to
/// another place near the middle; the tissue is at rest until 0.7 s and between two pulls.
struct Grasp {
  cv::Point2d hold;         ///< the place of the surface that it goes for, units
  cv::Vec3d pull{0, 0, 0};  ///< how far it has moved that place, units
  double sigma = 1;         ///< units in which the pull falls off to 1/e; longer than `pull`, so that nothing folds
  double in = 0;            ///< 0…1: how far the instrument has come in
  double open = 0;          ///< 0…1: its jaws
  cv::Point2d port{0, 0};   ///< where it comes from, in shares of the picture's width and height
  bool coloured = false;

  /// How far a place (units) is moved.
  cv::Vec3d at(double u, double v) const;
};

Grasp grasp_at(double time, double strength, std::uint64_t seed);

/// No point is ever moved farther sideways, units.
double grasp_reach(double strength);

}  // namespace csd::sim
