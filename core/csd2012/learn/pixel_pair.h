// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <cstdint>

namespace csd {

/// Two pixel indices; the test of a node (Eq. 2) compares them.
struct PixelPair {
  std::uint16_t p1 = 0, p2 = 0;

  bool operator==(const PixelPair &) const = default;
};

/// Eq. 2: the child of a node for a patch with pixels P1 and P2: 0 for P1 > P2, 1 for P1 = P2, 2 for P1 < P2.
/// Branchless, because the result is unpredictable.
constexpr int child_of(std::uint8_t p1, std::uint8_t p2) {
  return (p1 <= p2) + (p1 < p2);
}

}  // namespace csd
