// SPDX-License-Identifier: LGPL-2.1-or-later
#include "sim/fragments.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <utility>

namespace csd::sim {
namespace {

constexpr int bits = 8;  // of a pixel's fraction: fixed point, so that neighbours share exact edges
constexpr int one = 1 << bits;

int snap(double x) {
  return static_cast<int>(std::floor(std::clamp(x, -20000.0, 20000.0) * one + 0.5));
}

int ceil_pixel(int x) {
  return (x + one - 1) >> bits;
}

/// Twice the signed area between a point and the edge from a to b; a pixel on a shared edge belongs to one side only.
struct Edge {
  std::int64_t value, dx, dy;  // at the first pixel, and per pixel
};

Edge edge(cv::Point a, cv::Point b, cv::Point first) {
  const std::int64_t ex = b.x - a.x, ey = b.y - a.y;
  std::int64_t value = ex * (first.y - a.y) - ey * (first.x - a.x);
  const bool top_left = ey < 0 || (ey == 0 && ex > 0);
  if (!top_left) value -= 1;
  return {value, -ey * one, ex * one};
}

}  // namespace

void Fragments::reset(cv::Size size) {
  size_ = size;
  data_.resize(static_cast<std::size_t>(size.area()));
  for (Fragment &f : data_) f[Fragment::depth] = nothing;
}

template <std::size_t Groups, bool Shared>
void Fragments::draw_triangle(std::size_t ia, std::size_t ib, std::size_t ic, const std::vector<Fragment> &corners,
                              const Part *part) {
  cv::Point a = snapped_[ia], b = snapped_[ib], c = snapped_[ic];
  std::int64_t area =
      static_cast<std::int64_t>(b.x - a.x) * (c.y - a.y) - static_cast<std::int64_t>(b.y - a.y) * (c.x - a.x);
  if (area == 0) return;
  if (area < 0) {  // a back face, inside a fold: it still hides or is hidden
    std::swap(b, c);
    std::swap(ib, ic);
    area = -area;
  }
  const int left = std::max(0, ceil_pixel(std::min({a.x, b.x, c.x})));
  const int right = std::min(size_.width - 1, std::max({a.x, b.x, c.x}) >> bits);
  const int top = std::max(0, ceil_pixel(std::min({a.y, b.y, c.y})));
  const int bottom = std::min(size_.height - 1, std::max({a.y, b.y, c.y}) >> bits);
  if (left > right || top > bottom) return;

  const cv::Point first{left * one, top * one};
  Edge e0 = edge(a, b, first), e1 = edge(b, c, first), e2 = edge(c, a, first);

  // Values are linear in x and y over the triangle.
  constexpr std::size_t n = 4 * Groups;
  std::array<float, n> start, along_x, along_y;
  const float scale = static_cast<float>(one) / static_cast<float>(area);
  const auto bx = static_cast<float>(b.x - a.x), by = static_cast<float>(b.y - a.y);
  const auto cx = static_cast<float>(c.x - a.x), cy = static_cast<float>(c.y - a.y);
  const float x0 = static_cast<float>(first.x - a.x) / one, y0 = static_cast<float>(first.y - a.y) / one;
  const float *va = corners[ia].value.data(), *vb = corners[ib].value.data(), *vc = corners[ic].value.data();
  for (std::size_t k = 0; k < n; ++k) {
    const float db = vb[k] - va[k], dc = vc[k] - va[k];
    along_x[k] = (db * cy - dc * by) * scale;
    along_y[k] = (dc * bx - db * cx) * scale;
    start[k] = va[k] + x0 * along_x[k] + y0 * along_y[k];
  }
  for (int y = top; y <= bottom; ++y) {
    std::int64_t v0 = e0.value, v1 = e1.value, v2 = e2.value;
    Fragment *p = data_.data() + static_cast<std::size_t>(y) * static_cast<std::size_t>(size_.width) + left;
    std::array<float, n> value = start;
    for (int x = left; x <= right; ++x, ++p) {
      bool drawn = (v0 | v1 | v2) >= 0 && value[0] < p->value[0];
      if constexpr (Shared) drawn = drawn && part->belongs(value[Fragment::u], value[Fragment::v]);
      if (drawn) {
        for (std::size_t k = 0; k < n; ++k) p->value[k] = value[k];
      }
      v0 += e0.dx;
      v1 += e1.dx;
      v2 += e2.dx;
      for (std::size_t k = 0; k < n; ++k) value[k] += along_x[k];
    }
    e0.value += e0.dy;
    e1.value += e1.dy;
    e2.value += e2.dy;
    for (std::size_t k = 0; k < n; ++k) start[k] += along_y[k];
  }
}

template <std::size_t Groups>
void Fragments::draw(int columns, int rows, const std::vector<Fragment> &corners, const Part *part) {
  for (int j = 0; j + 1 < rows; ++j) {
    for (int i = 0; i + 1 < columns; ++i) {
      const std::size_t a =
          static_cast<std::size_t>(j) * static_cast<std::size_t>(columns) + static_cast<std::size_t>(i);
      const std::size_t b = a + 1, c = a + static_cast<std::size_t>(columns), d = c + 1;
      bool shared = false;
      if (part) {
        int own = 0;
        bool nobodys = false;
        for (const std::size_t corner : {a, b, c, d}) {
          own += part->owners[corner] == part->owner;
          nobodys |= part->owners[corner] == Part::nobody;
        }
        if (own == 0 || nobodys) continue;
        shared = own < 4 && part->belongs;
      }
      const auto triangle = [&](std::size_t i0, std::size_t i1, std::size_t i2) {
        if (shared) {
          draw_triangle<Groups, true>(i0, i1, i2, corners, part);
        } else {
          draw_triangle<Groups, false>(i0, i1, i2, corners, part);
        }
      };
      // Alternates the diagonals, so that interpolation errors have no preferred direction.
      if ((i + j) % 2 == 0) {
        triangle(a, b, d);
        triangle(a, d, c);
      } else {
        triangle(a, b, c);
        triangle(b, d, c);
      }
    }
  }
}

void Fragments::draw_grid(int columns, int rows, const std::vector<cv::Point2d> &image,
                          const std::vector<Fragment> &corners, std::size_t used, const Part *part) {
  snapped_.clear();
  for (const auto &p : image) snapped_.emplace_back(snap(p.x), snap(p.y));
  switch ((used + 3) / 4) {
    case 1:
    case 2:
      return draw<2>(columns, rows, corners, part);
    case 3:
      return draw<3>(columns, rows, corners, part);
    default:
      return draw<4>(columns, rows, corners, part);
  }
}

}  // namespace csd::sim
