// SPDX-License-Identifier: LGPL-2.1-or-later
#include "sim/mesh.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "sim/ieee_math.h"

namespace csd::sim {
namespace {

constexpr double hollow_finer = 0.6;  // rings are narrower than other deformations

/// A rectangle of pixels, before deformation, with all tissue that deformation may bring into the picture.
struct Extent {
  double left, top, right, bottom;
};

/// Starts `bound` pixels outside the picture and moves each side inwards while what it cuts off stays out of sight.
class ExtentFinder {
 public:
  ExtentFinder(const Surface &surface, const Surface::Moment &moment, const Camera &camera, cv::Size size, double step)
      : surface_(surface), moment_(moment), camera_(camera), size_(size), step_(step) {}

  Extent find(double bound) const {
    const double w = size_.width, h = size_.height;
    Extent e{-bound, -bound, w + bound, h + bound};
    while (e.left < -step_ && !seen({e.left + step_, e.top}, {e.left + step_, e.bottom})) e.left += step_;
    while (e.right > w + step_ && !seen({e.right - step_, e.top}, {e.right - step_, e.bottom})) e.right -= step_;
    while (e.top < -step_ && !seen({e.left, e.top + step_}, {e.right, e.top + step_})) e.top += step_;
    while (e.bottom > h + step_ && !seen({e.left, e.bottom - step_}, {e.right, e.bottom - step_})) e.bottom -= step_;
    return e;
  }

 private:
  bool seen(cv::Point2d a, cv::Point2d b) const {
    const int n = std::max(2, static_cast<int>(cv::norm(b - a) / step_));
    for (int i = 0; i <= n; ++i) {
      const cv::Point2d uv = camera_.to_plane(a + (b - a) * (static_cast<double>(i) / n));
      const cv::Point3d p = camera_.project(moment_.at(surface_.place(uv.x, uv.y)));
      if (p.x > -step_ && p.x < size_.width + step_ && p.y > -step_ && p.y < size_.height + step_) return true;
    }
    return false;
  }

  const Surface &surface_;
  const Surface::Moment &moment_;
  const Camera &camera_;
  cv::Size size_;
  double step_;
};

}  // namespace

void Mesh::build(const Surface &surface, const Surface::Moment &moment, const Camera &camera, cv::Size size) {
  const double scale = size.height / units_high, step = cell * scale * (surface.hollow() ? hollow_finer : 1);
  // Points below the plane appear nearer to the middle than on the plane.
  const double half = 0.5 * std::sqrt(1.0 * size.width * size.width + 1.0 * size.height * size.height);
  const double bound =
      std::min(surface.reach() * camera.magnification + half * (surface.hollow() ? 1.6 : 0.6), 3.0 * half);
  const Extent e = ExtentFinder(surface, moment, camera, size, 16 * scale).find(bound);

  columns = static_cast<int>((e.right - e.left) / step) + 2;
  rows = static_cast<int>((e.bottom - e.top) / step) + 2;
  points.resize(static_cast<std::size_t>(columns) * static_cast<std::size_t>(rows));
  for (int j = 0; j < rows; ++j) {
    for (int i = 0; i < columns; ++i) {
      Point &p = points[static_cast<std::size_t>(j) * static_cast<std::size_t>(columns) + static_cast<std::size_t>(i)];
      const cv::Point2d uv = camera.to_plane({e.left + i * step, e.top + j * step});
      p.place = surface.place(uv.x, uv.y);
      p.position = moment.at(p.place);
      p.image = camera.project(p.position);
    }
  }
  find_slopes();
}

void Mesh::move_with(std::uint8_t sheet, const Surface::Moment &moment, const Camera &camera) {
  for (Point &p : points) {
    p.position = moment.at(p.place, sheet);
    p.image = camera.project(p.position);
  }
  find_slopes();
}

void Mesh::lay_on_bed(const Surface::Moment &moment, const Camera &camera) {
  for (Point &p : points) {
    p.position = moment.bed(p.place);
    p.image = camera.project(p.position);
  }
  find_slopes();
}

void Mesh::find_slopes() {
  const auto at = [this](int i, int j) -> const Point & {
    i = std::clamp(i, 0, columns - 1);
    j = std::clamp(j, 0, rows - 1);
    return points[static_cast<std::size_t>(j) * static_cast<std::size_t>(columns) + static_cast<std::size_t>(i)];
  };
  for (int j = 0; j < rows; ++j) {
    for (int i = 0; i < columns; ++i) {
      const Point &left = at(i - 1, j), &right = at(i + 1, j), &up = at(i, j - 1), &down = at(i, j + 1);
      Point &p = points[static_cast<std::size_t>(j) * static_cast<std::size_t>(columns) + static_cast<std::size_t>(i)];
      const cv::Vec3d n = (right.position - left.position).cross(down.position - up.position);
      p.normal = n / std::max(std::sqrt(n.dot(n)), 1e-9);
      // The squared length, in units, that a pixel covers along each grid direction.
      const auto covered = [](const Point &a, const Point &b) {
        const double du = a.place.u - b.place.u, dv = a.place.v - b.place.v, dx = a.image.x - b.image.x,
                     dy = a.image.y - b.image.y;
        return (du * du + dv * dv) / std::max(dx * dx + dy * dy, 1e-3);
      };
      p.units_log2 = 0.5 * log2_of(std::max({covered(left, right), covered(up, down), 1e-6}));
    }
  }
}

}  // namespace csd::sim
