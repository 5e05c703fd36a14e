// SPDX-License-Identifier: LGPL-2.1-or-later
#include "image/colour_space.h"

#include <cstddef>
#include <numeric>

namespace csd {
namespace {

constexpr ColourSpace intensity{1, 1, 1};

/// Of w and −w, keeps the one whose first component that is not 0 is positive; of multiples, the shortest.
constexpr bool canonical(int r, int g, int b) {
  const int first = r != 0 ? r : g != 0 ? g : b;
  return first > 0 && std::gcd(std::gcd(r, g), b) == 1;
}

constexpr std::array<ColourSpace, 49> enumerate() {
  std::array<ColourSpace, 49> spaces{};
  std::size_t n = 0;
  spaces.at(n++) = intensity;
  for (int r = -2; r <= 2; ++r)
    for (int g = -2; g <= 2; ++g)
      for (int b = -2; b <= 2; ++b)
        if (canonical(r, g, b) && !(r == 1 && g == 1 && b == 1))
          spaces.at(n++) = {static_cast<std::int8_t>(r), static_cast<std::int8_t>(g), static_cast<std::int8_t>(b)};
  return spaces;
}

}  // namespace

const std::array<ColourSpace, 49> &colour_spaces() {
  static constexpr std::array<ColourSpace, 49> spaces = enumerate();
  return spaces;
}

}  // namespace csd
