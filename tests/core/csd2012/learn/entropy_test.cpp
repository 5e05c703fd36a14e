// SPDX-License-Identifier: LGPL-2.1-or-later
#include "csd2012/learn/entropy.h"

#include <gtest/gtest.h>

#include <cmath>

namespace csd {
namespace {

TEST(Entropy, Equation3IsAsComputedByHand) {
  const Entropy h(64);
  EXPECT_EQ(h.of(0, 0), 0.0);
  EXPECT_EQ(h.of(1, 0), 0.0);
  EXPECT_EQ(h.of(0, 37), 0.0);
  EXPECT_EQ(h.of(1, 1), 2.0);                             // 2·log2 2
  EXPECT_EQ(h.of(8, 8), 16.0);                            // 16·4 − 8·3 − 8·3
  EXPECT_NEAR(h.of(1, 3), 8 - 3 * std::log2(3.0), 1e-8);  // 4·2 − 0 − 3·log2 3
  // The sum over the three subsets: 8 and 8, 2 and 2, 1 and 1.
  EXPECT_EQ(h.of(SplitCounts{8, 2, 1, 8, 2, 1}), 16.0 + 4 + 2);
  EXPECT_EQ(h.of(SplitCounts{8, 0, 1, 0, 5, 0}), 0.0);
  EXPECT_EQ(h.of(3, 7) + h.of(11, 5), h.of(5, 11) + h.of(7, 3));
}

}  // namespace
}  // namespace csd
