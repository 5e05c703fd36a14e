// SPDX-License-Identifier: LGPL-2.1-or-later
#include "sim/vessels.h"

#include <gtest/gtest.h>

namespace csd::sim {
namespace {

double drawn(const NoiseField &f) {
  double sum = 0;
  for (const float x : f.values()) {
    EXPECT_GE(x, 0);
    EXPECT_LE(x, 1);
    sum += x;
  }
  return sum;
}

NoiseField field(const VesselOptions &options, std::uint64_t seed = 1) {
  NoiseField f(256);
  draw_vessels(f, options, seed, 7);
  return f;
}

TEST(Vessels, GrowWithTheRequestedAmount) {
  const VesselOptions plain{4, 4, 0.8, 150, 0.02, 0};
  VesselOptions wide = plain, branching = plain, none = plain;
  wide.width = 8;
  branching.branches = 5;
  none.trees = 0;
  const double area = drawn(field(plain));
  // Four tapering vessels of about 150 × 4.
  EXPECT_GT(area, 4 * 150 * 4 * 0.3);
  EXPECT_LT(area, 4 * 150 * 4 * 1.5);
  EXPECT_GT(drawn(field(wide)), 1.5 * area);
  EXPECT_GT(drawn(field(branching)), 1.15 * area);
  EXPECT_EQ(drawn(field(none)), 0);
}

TEST(Vessels, DependOnTheirSeed) {
  EXPECT_EQ(field({}).values(), field({}).values());
  EXPECT_NE(field({}).values(), field({}, 2).values());
}

TEST(Vessels, CrossTheEdgesOfARepeatingField) {
  const NoiseField f = field({20, 6, 1, 300, 0.01, 2});
  int crossing = 0;
  for (int y = 0; y < 256; ++y) crossing += f.at(0, y) > 0.5F && f.at(255, y) > 0.5F;
  EXPECT_GT(crossing, 5);
}

}  // namespace
}  // namespace csd::sim
