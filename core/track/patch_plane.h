// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <array>
#include <cstddef>

namespace csd {

/// One value for each of a patch's 21 × 21 samples, offsets v in [−10, 10]².
///
/// Rows are padded to 24 and there are 22 of them: two rows are 48 floats, thus whole vectors of 4, 8 or 16. Padding is
/// zero.
struct PatchPlane {
  static constexpr int radius = 10, side = 2 * radius + 1, stride = 24, rows = side + 1;
  static constexpr int pixels = side * side;
  static constexpr std::size_t size = stride * rows;

  float &at(int vx, int vy) { return data[index(vx, vy)]; }
  float at(int vx, int vy) const { return data[index(vx, vy)]; }
  static std::size_t index(int vx, int vy) { return static_cast<std::size_t>((vy + radius) * stride + vx + radius); }

  alignas(64) std::array<float, size> data{};
};

}  // namespace csd
