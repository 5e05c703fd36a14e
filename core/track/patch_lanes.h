// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <cstddef>

#include "track/patch_plane.h"

namespace csd::patch_lanes {

/// Two rows of a PatchPlane are whole vectors: column j of them has the same v.x in all pairs of rows, and v.y grows by
/// 2 from one pair to the next. Padding takes its row's last sample, so that it lies within the patch's bounds.
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

}  // namespace csd::patch_lanes
