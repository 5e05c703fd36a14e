// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <array>
#include <cstddef>

namespace csd {

/// A value for each of a patch's 21 × 21 samples, at offsets v in [−10, 10]².
///
/// 22 rows, padded with zeros to 24: two rows are 48 floats, which are whole vectors of 4, 8 or 16.
struct PatchPlane {
  static constexpr int radius = 10, side = 2 * radius + 1, stride = 24, rows = side + 1;
  static constexpr int pixels = side * side;
  static constexpr std::size_t size = stride * rows;

  float &at(int vx, int vy) { return data[index(vx, vy)]; }
  float at(int vx, int vy) const { return data[index(vx, vy)]; }
  /// Calls visit(vx, vy, index) for each sample.
  template <class Visit>
  static void for_each_sample(Visit visit) {
    for (int y = -radius; y <= radius; ++y)
      for (int x = -radius; x <= radius; ++x) visit(x, y, index(x, y));
  }
  static std::size_t index(int vx, int vy) { return static_cast<std::size_t>((vy + radius) * stride + vx + radius); }

  alignas(64) std::array<float, size> data{};
};

namespace patch_lanes {
/// Two rows of a PatchPlane are whole vectors: column j has the same v.x in all pairs of rows, and v.y grows by 2 from
/// pair to pair. Padding repeats its row's last sample, so that it lies within the patch's bounds.
inline constexpr std::size_t period = 2 * PatchPlane::stride;
struct Table {
  alignas(64) float value[period];
};
inline constexpr Table make(bool vertical) {
  Table t{};
  for (std::size_t i = 0; i < period; ++i) {
    const auto column = static_cast<int>(i % PatchPlane::stride), row = static_cast<int>(i / PatchPlane::stride);
    const int x = column < PatchPlane::side ? column : PatchPlane::side - 1;
    t.value[i] = static_cast<float>((vertical ? row : x) - PatchPlane::radius);
  }
  return t;
}
inline constexpr Table x_table = make(false), y_table = make(true);
inline constexpr const float *x = x_table.value, *y = y_table.value;  ///< v of the first two rows

}  // namespace patch_lanes

}  // namespace csd
