// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <opencv2/core.hpp>

#include <cstdint>
#include <vector>

#include "sim/camera.h"
#include "sim/surface.h"

namespace csd::sim {

/// The part of the surface that a camera may see, as a grid of points. Cells are about `Mesh::cell` pixels wide on flat
/// tissue at any distance, so linear interpolation between the points is accurate to some hundredths of a pixel.
struct Mesh {
  static constexpr double cell = 5;  ///< pixels at 480 lines

  struct Point {
    Surface::Place place;
    cv::Vec3d position;     ///< in the scene, units
    cv::Point3d image;      ///< pixels, and depth in units
    cv::Vec3d normal;       ///< towards the scope, length 1
    double units_log2 = 0;  ///< log₂ of units per pixel, in the direction with the most
  };

  int columns = 0, rows = 0;
  std::vector<Point> points;  ///< row by row

  /// Builds the mesh for `camera` and a picture of `size`; reuses memory.
  void build(const Surface &surface, const Surface::Moment &moment, const Camera &camera, cv::Size size);
  /// Moves the points of a mesh as if all of them belonged to `sheet`.
  void move_with(std::uint8_t sheet, const Surface::Moment &moment, const Camera &camera);
  /// Moves the mesh to the bed under the tissue.
  void lay_on_bed(const Surface::Moment &moment, const Camera &camera);

 private:
  void find_slopes();
};

}  // namespace csd::sim
