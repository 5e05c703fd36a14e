// SPDX-License-Identifier: LGPL-2.1-or-later
#include "csd/similarity.h"

#include <cmath>
#include <cstddef>

namespace csd {
namespace {

/// The similarity with this a and b that maps `from` to `to`.
Similarity about(cv::Point2d from, cv::Point2d to, double a, double b) {
  return {a, b, to - cv::Point2d(a * from.x - b * from.y, b * from.x + a * from.y)};
}

}  // namespace

double Similarity::scale() const {
  return std::hypot(a, b);
}

Similarity similarity_through(const Correspondence &u, const Correspondence &v) {
  const auto from = v.from - u.from, to = v.to - u.to;
  const double size = squared(from);
  return about(u.from, u.to, from.dot(to) / size, (from.x * to.y - from.y * to.x) / size);
}

PointMoments PointMoments::of(std::span<const Correspondence> points, const double *weights) {
  PointMoments m;
  for (std::size_t i = 0; i < points.size(); ++i) {
    m.weight += weights[i];
    m.from += weights[i] * points[i].from;
    m.to += weights[i] * points[i].to;
  }
  m.from /= m.weight;
  m.to /= m.weight;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const auto x = points[i].from - m.from, y = points[i].to - m.to;
    const auto w = weights[i];
    m.cxx += w * x.x * x.x;
    m.cxy += w * x.x * x.y;
    m.cyy += w * x.y * x.y;
    m.dxx += w * y.x * x.x;
    m.dxy += w * y.x * x.y;
    m.dyx += w * y.y * x.x;
    m.dyy += w * y.y * x.y;
  }
  return m;
}

bool PointMoments::degenerate() const {
  return !(cxx + cyy > 1e-9 * weight);
}

Similarity fit_similarity(const PointMoments &m) {
  const double trace = m.cxx + m.cyy;
  return about(m.from, m.to, (m.dxx + m.dyy) / trace, (m.dyx - m.dxy) / trace);
}

}  // namespace csd
