// SPDX-License-Identifier: LGPL-2.1-or-later
#include "image/colour_space.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

namespace csd {
namespace {

TEST(ColourSpace, HasEveryDirectionOnceIntensityFirst) {
  const auto &spaces = colour_spaces();
  EXPECT_EQ(spaces[0], (ColourSpace{1, 1, 1}));
  EXPECT_EQ(spaces[1], (ColourSpace{0, 0, 1}));
  EXPECT_EQ(spaces[48], (ColourSpace{2, 2, 1}));
  // Each of the 124 vectors is a multiple of exactly one space: their cross product is 0.
  for (int r = -2; r <= 2; ++r)
    for (int g = -2; g <= 2; ++g)
      for (int b = -2; b <= 2; ++b) {
        if (r == 0 && g == 0 && b == 0) continue;
        const auto parallel = std::count_if(spaces.begin(), spaces.end(), [&](const ColourSpace &s) {
          return s.r * g == s.g * r && s.g * b == s.b * g && s.r * b == s.b * r;
        });
        EXPECT_EQ(parallel, 1) << r << ' ' << g << ' ' << b;
      }
}

TEST(ColourSpace, AppliesAsComputedByHand) {
  EXPECT_EQ((ColourSpace{1, 1, 1}.apply(10, 20, 31)), 20);     // 61 / 3 = 20.3
  EXPECT_EQ((ColourSpace{1, -1, 0}.apply(100, 200, 9)), 77);   // (-100 + 255) / 2 = 77.5
  EXPECT_EQ((ColourSpace{2, -2, 1}.apply(255, 0, 255)), 255);  // top of the range
  EXPECT_EQ((ColourSpace{2, -2, 1}.apply(0, 255, 0)), 0);      // bottom of the range
  EXPECT_EQ((ColourSpace{0, 0, 1}.apply(1, 2, 3)), 3);
  EXPECT_EQ((ColourSpace{2, 2, 1}.apply(100, 50, 7)), 61);  // 307 / 5 = 61.4
}

TEST(ColourSpace, ExtremesReachTheWholeRange) {
  for (const ColourSpace &s : colour_spaces()) {
    const auto corner = [](int w, bool top) { return static_cast<std::uint8_t>((w > 0) == top ? 255 : 0); };
    EXPECT_EQ(s.apply(corner(s.r, true), corner(s.g, true), corner(s.b, true)), 255);
    EXPECT_EQ(s.apply(corner(s.r, false), corner(s.g, false), corner(s.b, false)), 0);
  }
}

}  // namespace
}  // namespace csd
