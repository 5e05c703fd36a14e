// SPDX-License-Identifier: LGPL-2.1-or-later
#include "csd2012/learn/pixel_pair.h"

#include <gtest/gtest.h>

namespace csd {
namespace {

TEST(PixelPair, Equation2HoldsForAllValues) {
  for (int a = 0; a < 256; ++a)
    for (int b = 0; b < 256; ++b) {
      const int child = child_of(static_cast<std::uint8_t>(a), static_cast<std::uint8_t>(b));
      ASSERT_EQ(child, a > b ? 0 : a == b ? 1 : 2) << a << ' ' << b;
    }
}

}  // namespace
}  // namespace csd
