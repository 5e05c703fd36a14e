// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <cstdint>

namespace csd {

/// Two pixel indices; the test of a node (Eq. 2) compares them.
struct PixelPair {
  std::uint16_t p1 = 0, p2 = 0;

  bool operator==(const PixelPair &) const = default;
};

/// Eq. 2: into which of a node's children a patch goes whose pixels are P1 and P2: 0 for P1 > P2, 1 for P1 = P2, 2 for
/// P1 < P2. Without a branch, for none could be predicted.
constexpr int child_of(std::uint8_t p1, std::uint8_t p2) {
  return (p1 <= p2) + (p1 < p2);
}

}  // namespace csd
