// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <opencv2/core.hpp>

namespace csd::sim {

/// A hollow organ seen along its axis: near walls at the picture's border, its far end in the middle, ring-like folds
/// between. It is the plane z = 0 (strength 0) moved along the rays through the scope's initial position, so texture
/// coordinates stay close to those of the initial picture; the rings then rise towards the axis.
class Cavity {
 public:
  explicit Cavity(double strength) : strength_(strength) {}

  bool any() const { return strength_ > 0; }

  /// Position of the wall, units. `relief` is that of the plane.
  cv::Vec3d at(double u, double v, double relief) const;
  /// The cosine between a wall without folds and the direction to the scope's initial position.
  double facing(double u, double v) const;

  double reach() const;  ///< upper bound of a point's sideways distance from its (u, v), units

 private:
  double depth(double radius) const;  // relative to the plane's distance

  double strength_;
};

}  // namespace csd::sim
