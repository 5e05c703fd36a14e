// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <array>
#include <cstdint>

#include "image/frame_view.h"

namespace csd {

/// Number of samples in one row of a component, in its own grid (subsampled if the component is).
inline int component_columns(const FrameView &view, int component) {
  const int sub = view.packing == Packing::v210 ? (component == 0 ? 0 : 1) : view.component[component].sub_x;
  return (view.width + (1 << sub) - 1) >> sub;
}
inline int component_rows(const FrameView &view, int component) {
  const int sub = view.packing == Packing::v210 ? 0 : view.component[component].sub_y;
  return (view.rows + (1 << sub) - 1) >> sub;
}

/// Reads `n` samples from column `first` of row `row` of a component (0…2) as 8 bit. `row` and `first` are in the
/// component's own grid and must lie in it. Deeper samples are rounded to nearest and clamped to 255, or mapped by
/// their Component's `black` and `gain`.
void read_samples(const FrameView &view, int component, int row, int first, int n, std::uint8_t *out);

/// The same for all components whose `out` is not null, which must have the same grid: a PixelReader reads them at
/// once.
void read_samples(const FrameView &view, int row, int first, int n, const std::array<std::uint8_t *, 3> &out);

/// The same without SIMD, the bit-exact reference for tests. A PixelReader has no such reference.
namespace scalar {
void read_samples(const FrameView &view, int component, int row, int first, int n, std::uint8_t *out);
}

}  // namespace csd
