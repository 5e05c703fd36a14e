// SPDX-License-Identifier: LGPL-2.1-or-later
#include "patch/patch_plane.h"

#include <gtest/gtest.h>

#include <set>

namespace csd {
namespace {

TEST(PatchPlane, EverySampleHasItsPlace) {
  std::set<std::size_t> places;
  for (int y = -10; y <= 10; ++y)
    for (int x = -10; x <= 10; ++x) {
      const std::size_t i = PatchPlane::index(x, y);
      places.insert(i);
      EXPECT_LT(i, PatchPlane::size);
      // The lane tables repeat every two rows: y is the table's value plus 2 a period.
      EXPECT_EQ(patch_lanes::x[i % patch_lanes::period], x);
      EXPECT_EQ(patch_lanes::y[i % patch_lanes::period] + 2 * static_cast<float>(i / patch_lanes::period), y);
    }
  EXPECT_EQ(places.size(), 441u);
}

TEST(PatchPlane, IsZeroAndAligned) {
  const PatchPlane p;
  for (const float v : p.data) EXPECT_EQ(v, 0);
  EXPECT_EQ(alignof(PatchPlane), 64u);
}

}  // namespace
}  // namespace csd
