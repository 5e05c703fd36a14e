// SPDX-License-Identifier: LGPL-2.1-or-later
#include "base/random.h"

#include <gtest/gtest.h>

#include <array>

namespace csd {
namespace {

TEST(Random, TheSameStreamGivesTheSameNumbers) {
  Random a(1, 2), b(1, 2), c(1, 3), d(2, 2);
  const std::uint64_t x = a.next();
  EXPECT_EQ(x, b.next());
  EXPECT_NE(x, c.next());
  EXPECT_NE(x, d.next());
}

TEST(Random, BelowIsUniform) {
  Random random(3);
  std::array<int, 7> counts{};
  for (int i = 0; i < 70000; ++i) ++counts.at(random.below(7));
  for (const int c : counts) EXPECT_NEAR(c, 10000, 500);  // over 5 standard deviations
}

TEST(Random, UniformAndNormalHaveTheirMoments) {
  Random random(4);
  constexpr int n = 200000;
  double u = 0, z = 0, z2 = 0, z4 = 0;
  int within = 0;
  for (int i = 0; i < n; ++i) {
    const double x = random.uniform(2, 4);
    EXPECT_TRUE(x >= 2 && x < 4);
    u += x;
    const double y = random.normal();
    z += y;
    z2 += y * y;
    z4 += y * y * y * y;
    within += y > -1 && y < 1;
  }
  EXPECT_NEAR(u / n, 3, .01);
  EXPECT_NEAR(z / n, 0, .012);
  EXPECT_NEAR(z2 / n, 1, .02);
  EXPECT_NEAR(z4 / n, 2.9, .1);  // for the sum of 12 uniforms: 3 − 6/(5·12)
  EXPECT_NEAR(static_cast<double>(within) / n, .683, .008);
}

}  // namespace
}  // namespace csd
