// SPDX-License-Identifier: LGPL-2.1-or-later
#include "sim/highlights.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace csd::sim {
namespace {

/// The saturated share of a patch of tissue with this normal, seen from straight above.
double share(const Highlights &h, float normal_x, float slope_x = 0, float gloss = 1) {
  double sum = 0;
  for (int v = 0; v < 120; ++v)
    for (int u = 0; u < 120; ++u) {
      Fragment f;
      f[Fragment::u] = static_cast<float>(4 * u);
      f[Fragment::v] = static_cast<float>(4 * v);
      f[Fragment::normal_x] = normal_x;
      sum += h.at(f, slope_x, 0, gloss).core;
    }
  return sum / (120 * 120);
}

TEST(Highlights, AppearWhereTheSurfaceFacesTheLamp) {
  const Highlights h(1, 4);
  EXPECT_GT(share(h, 0), 0.01);
  EXPECT_LT(share(h, 0), 0.5);
  EXPECT_EQ(share(h, 0.6F), 0);
  // 0.5 to the side, the surface must tilt back to the lamp: n = −slope/√(1+slope²).
  EXPECT_NEAR(share(h, static_cast<float>(-0.5 / std::sqrt(1.25)), 0.5F), share(h, 0), 1e-3);
  EXPECT_LT(share(h, 0, 0.5F), 0.2 * share(h, 0));
}

TEST(Highlights, GrowWithStrengthAndGloss) {
  EXPECT_GT(share(Highlights(2, 4), 0), share(Highlights(1, 4), 0));
  EXPECT_GT(share(Highlights(1, 4), 0), share(Highlights(1, 4), 0, 0, 0.6F));
  EXPECT_EQ(share(Highlights(0, 4), 0), 0);
}

TEST(Highlights, GlowAroundTheirCore) {
  const Highlights h(1, 4);
  int glowing = 0, blind = 0;
  for (int u = 0; u < 2000; ++u) {
    Fragment f;
    f[Fragment::u] = static_cast<float>(0.7 * u);
    f[Fragment::v] = static_cast<float>(1.3 * u);
    const auto value = h.at(f, 0, 0, 1);
    EXPECT_GE(value.glow, 0);
    EXPECT_LE(value.glow, 1);
    if (value.core > 0) {
      EXPECT_GT(value.glow, 0);
    }
    glowing += value.glow > 0;
    blind += value.core > 0.5F;
  }
  EXPECT_GT(glowing, blind);
  EXPECT_GT(blind, 0);
}

}  // namespace
}  // namespace csd::sim
