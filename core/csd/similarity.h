// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <opencv2/core.hpp>

#include <span>

namespace csd {

/// A tissue point at `from` and where it is now, `to`.
struct Correspondence {
  cv::Point2d from, to;

  Correspondence reversed() const { return {to, from}; }
};

inline double squared(cv::Point2d p) {
  return p.dot(p);
}

/// Rotation, zoom and shift: to = (a −b; b a)·from + shift.
struct Similarity {
  double a = 1, b = 0;
  cv::Point2d shift;

  cv::Point2d operator()(cv::Point2d p) const { return {a * p.x - b * p.y + shift.x, b * p.x + a * p.y + shift.y}; }
  double scale() const;
  bool zooms_at_most(double zoom) const { return scale() <= zoom && scale() * zoom >= 1; }  ///< either way
};

/// The similarity through two points. Not for two that coincide.
Similarity similarity_through(const Correspondence &u, const Correspondence &v);

/// Weighted moments of correspondences x → y about their weighted means.
struct PointMoments {
  double weight = 0;                          ///< Σ w
  cv::Point2d from, to;                       ///< means
  double cxx = 0, cxy = 0, cyy = 0;           ///< C = Σ w x xᵀ
  double dxx = 0, dxy = 0, dyx = 0, dyy = 0;  ///< D = Σ w y xᵀ
  bool degenerate() const;                    ///< the points coincide
  static PointMoments of(std::span<const Correspondence> points, const double *weights);
};

/// The weighted least-squares similarity. Not if degenerate().
Similarity fit_similarity(const PointMoments &moments);

}  // namespace csd
