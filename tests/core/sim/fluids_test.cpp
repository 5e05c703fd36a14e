// SPDX-License-Identifier: LGPL-2.1-or-later
#include "sim/fluids.h"

#include <gtest/gtest.h>

namespace csd::sim {
namespace {

struct Covered {
  int blood = 0, water = 0, changed = 0;
};

Covered count(const std::string &effects, double time) {
  Effects e;
  e.set(effects);
  const Fluids fluids(e, 3);
  Covered c;
  for (int v = -240; v < 240; v += 8)
    for (int u = -320; u < 320; u += 8) {
      Fragment f;
      fluids.wet(time, u, v, f);
      c.blood += cover(f[Fragment::blood]) >= 0.5F;
      c.water += cover(f[Fragment::water]) >= 0.5F;
      c.changed += cover(f[Fragment::changed]) >= 0.5F;
    }
  return c;
}

TEST(Fluids, BloodOozesIsWipedAndLeavesAMark) {
  EXPECT_EQ(count("blood", 2.9).blood, 0);
  const int soon = count("blood", 5).blood, later = count("blood", 8.5).blood;
  EXPECT_GT(soon, 20);
  EXPECT_GT(later, 2 * soon);
  EXPECT_EQ(count("blood", 9).changed, 0);
  const Covered after = count("blood", 13);
  EXPECT_EQ(after.blood, 0);
  EXPECT_GT(after.changed, later / 2);
  EXPECT_EQ(count("blood", 22).changed, after.changed);
  EXPECT_GE(count("blood", 3000).changed, after.changed);  // for good
}

TEST(Fluids, WaterRunsAndLeavesAMark) {
  EXPECT_EQ(count("irrigation", 8).water, 0);
  EXPECT_GT(count("irrigation", 10).water, 200);
  const Covered after = count("irrigation", 14);
  EXPECT_EQ(after.water, 0);
  EXPECT_GT(after.changed, 100);
}

TEST(Fluids, HappenAtFourPlacesInTurn) {
  int last = 0;
  for (int i = 0; i < 4; ++i) {
    const int now = count("blood", 20 * i + 15).changed;
    EXPECT_GT(now, last + 50);
    last = now;
  }
  EXPECT_EQ(count("blood", 95).changed, last);
}

TEST(Fluids, StrongerIsLarger) {
  EXPECT_GT(count("blood=2", 9).blood, 1.5 * count("blood=1", 9).blood);
  EXPECT_EQ(count("blood=0", 9).blood, 0);
}

}  // namespace
}  // namespace csd::sim
