// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <opencv2/core.hpp>

namespace csd::sim {

/// A hollow organ seen along its axis: near walls at the picture's border, its far end in the middle, folds like rings
/// between. It is the plane z = 0 (strength 0) moved along the rays that meet at the scope's first place, so that
/// texture coordinates stay about those of the first picture; the rings then rise from it towards the axis.
class Cavity {
 public:
  explicit Cavity(double strength) : strength_(strength) {}

  bool any() const { return strength_ > 0; }

  /// Where the wall is, units. `relief` is that of the plane.
  cv::Vec3d at(double u, double v, double relief) const;
  /// How a wall without folds faces the scope's first place: the cosine.
  double facing(double u, double v) const;

  double reach() const;  ///< no point is farther from its (u, v), units, sideways

 private:
  double depth(double radius) const;  // in distances of the plane

  double strength_;
};

}  // namespace csd::sim
