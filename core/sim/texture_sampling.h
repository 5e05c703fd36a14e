// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <array>
#include <cstddef>

#include "sim/texture_map.h"

/// Trilinear sampling of a texture pyramid for a row of fragments.
namespace csd::sim {

/// B, G, R, gloss of each of `n` fragments; the result for an empty fragment is undefined. Adds `bias` to their levels.
/// Uses the machine's best vector instructions (Highway).
void sample_vectors(const TextureMap::Level *levels, std::size_t level_count, float bias, const Fragment *fragments,
                    std::size_t n, std::array<float, 4> *out);

/// The scalar version, with identical bits.
void sample_scalar(const TextureMap::Level *levels, std::size_t level_count, float bias, const Fragment *fragments,
                   std::size_t n, std::array<float, 4> *out);

/// A fragment's place on a level.
struct TexelPlace {
  const std::uint8_t *upper, *lower;  ///< two texels each
  float fx, fy;
};

inline float floor_float(float x) {
  const auto i = static_cast<float>(static_cast<int>(x));
  return i > x ? i - 1 : i;
}

inline TexelPlace texel_place(const TextureMap::Level &l, float u, float v) {
  float x = u * l.per_unit + l.middle_x, y = v * l.per_unit + l.middle_y;
  x -= floor_float(x * l.inverse_width) * static_cast<float>(l.width);
  y -= floor_float(y * l.inverse_height) * static_cast<float>(l.height);
  // Rounding may have moved them just outside.
  int ix = static_cast<int>(x), iy = static_cast<int>(y);
  ix = ix < 0 ? 0 : ix >= l.width ? l.width - 1 : ix;
  iy = iy < 0 ? 0 : iy >= l.height ? l.height - 1 : iy;
  const std::uint8_t *p = l.data + static_cast<std::size_t>(iy) * l.stride + 4 * static_cast<std::size_t>(ix);
  return {p, p + l.stride, x - static_cast<float>(ix), y - static_cast<float>(iy)};
}

/// The two levels around a fragment, and how far it is from the first to the second.
struct LevelPlace {
  std::size_t fine, coarse;
  float f;
};

inline LevelPlace level_place(float level, std::size_t count) {
  const auto top = static_cast<float>(count - 1);
  if (!(level > 0)) return {0, 0, 0};
  if (level >= top) return {count - 1, count - 1, 0};
  const auto fine = static_cast<std::size_t>(level);
  return {fine, fine + 1, level - static_cast<float>(fine)};
}

}  // namespace csd::sim
