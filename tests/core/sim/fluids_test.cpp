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

constexpr int all = 60 * 80;  // the number of places that count() looks at

TEST(Fluids, BloodOozesIsWipedAndLeavesAMark) {
  EXPECT_EQ(count("blood", 2.9).blood, 0);
  const int soon = count("blood", 5.5).blood, later = count("blood", 12.5).blood;
  EXPECT_GT(soon, 20);
  EXPECT_GT(later, 2 * soon);
  EXPECT_EQ(count("blood", 13).changed, 0);
  const Covered after = count("blood", 18.1);
  EXPECT_EQ(after.blood, 0);
  EXPECT_GT(after.changed, later / 2);
  EXPECT_EQ(count("blood", 3000).changed, after.changed);  // permanently
}

TEST(Fluids, WaterRunsAndLeavesAMark) {
  EXPECT_EQ(count("irrigation", 10.9).water, 0);
  EXPECT_GT(count("irrigation", 12.5).water, all / 2);
  const Covered after = count("irrigation", 15);
  EXPECT_EQ(after.water, 0);
  EXPECT_GT(after.changed, all / 4);
  EXPECT_EQ(count("irrigation", 3000).changed, after.changed);
}

TEST(Fluids, PlacesBleedAndAreWipedInTurn) {
  int blood = 0, changed = 0;
  for (int i = 0; i < 4; ++i) {
    const int bleeds = count("blood", 4.45 + 1.5 * i).blood, wiped = count("blood", 15 + i).changed;
    EXPECT_GT(bleeds, blood);
    EXPECT_GT(wiped, changed + all / 50);
    blood = bleeds;
    changed = wiped;
  }
}

TEST(Fluids, RepeatEachCycleOverTheirMarks) {
  const Covered first = count("blood,irrigation", 12.5), again = count("blood,irrigation", 52.5);
  EXPECT_EQ(again.blood, first.blood);
  EXPECT_EQ(again.water, first.water);
  EXPECT_EQ(first.changed, 0);
  EXPECT_GT(again.changed, all / 4);
}

TEST(Fluids, AStrongerEffectIsLarger) {
  EXPECT_GT(count("blood=2", 8).blood, 1.5 * count("blood=1", 8).blood);
  EXPECT_EQ(count("blood=0", 9).blood, 0);
}

}  // namespace
}  // namespace csd::sim
