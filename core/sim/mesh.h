// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <opencv2/core.hpp>

#include <cstdint>
#include <vector>

#include "sim/camera.h"
#include "sim/surface.h"

namespace csd::sim {

/// The part of the surface that a camera may see, as a grid of points. Its cells are about `Mesh::cell` pixels wide
/// wherever the surface lies flat, however near the scope is: the error of linear interpolation between the points
/// stays some hundredths of a pixel.
struct Mesh {
  static constexpr double cell = 5;  ///< pixels at 480 lines

  struct Point {
    Surface::Place place;
    cv::Vec3d position;     ///< in the scene, units
    cv::Point3d image;      ///< pixels, and depth in units
    cv::Vec3d normal;       ///< towards the scope, length 1
    double units_log2 = 0;  ///< log₂ of units per pixel, along the direction in which they are most
  };

  int columns = 0, rows = 0;
  std::vector<Point> points;  ///< row by row

  /// Makes the mesh of what `camera` sees in a picture of `size`; memory is reused.
  void build(const Surface &surface, const Surface::Moment &moment, const Camera &camera, cv::Size size);
  /// Moves the points of a built mesh as if all of them belonged to `sheet`.
  void move_with(std::uint8_t sheet, const Surface::Moment &moment, const Camera &camera);
  /// Lays the mesh onto the bed under the tissue.
  void lay_on_bed(const Surface::Moment &moment, const Camera &camera);

 private:
  void find_slopes();
};

}  // namespace csd::sim
