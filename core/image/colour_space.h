// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstdlib>

namespace csd {

/// One of the 49 linear colour spaces of Eq. 7: F = w1·R + w2·G + w3·B with w in {-2…2}, one per direction (multiples,
/// also negative ones, order pixels alike).
struct ColourSpace {
  std::int8_t r = 0, g = 0, b = 0;

  /// |w1| + |w2| + |w3|: the range of F is 255·span() wide.
  int span() const { return std::abs(r) + std::abs(g) + std::abs(b); }
  /// How far that range extends below 0.
  int below() const { return 255 * (std::max<int>(-r, 0) + std::max<int>(-g, 0) + std::max<int>(-b, 0)); }
  /// Eq. 7 of an RGB value, shifted to 0…255·span().
  int mix(int red, int green, int blue) const { return r * red + g * green + b * blue + below(); }

  /// Maps an RGB value to 0…255 by the space's analytic range (not the picture's), rounded down.
  std::uint8_t apply(std::uint8_t red, std::uint8_t green, std::uint8_t blue) const {
    return static_cast<std::uint8_t>(mix(red, green, blue) / std::max(span(), 1));
  }

  bool operator==(const ColourSpace &) const = default;
};

/// The 49 spaces in a fixed order: intensity, (1,1,1), comes first, then the others by (r, g, b), lexicographically.
/// The first component that is not 0 is positive: (0,0,1), (0,1,-2), (0,1,-1), … (2,2,1).
const std::array<ColourSpace, 49> &colour_spaces();

}  // namespace csd
