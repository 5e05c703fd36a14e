// SPDX-License-Identifier: LGPL-2.1-or-later
#include "sim/noise_field.h"

#include <gtest/gtest.h>

#include <cmath>
#include <set>

namespace csd::sim {
namespace {

TEST(NoiseField, IsNormalised) {
  const NoiseField f = fractal_noise(128, {{30, 1}, {8, 0.5}}, 3, 4);
  double sum = 0, squares = 0;
  for (const float x : f.values()) {
    sum += x;
    squares += static_cast<double>(x) * x;
  }
  EXPECT_NEAR(sum / (128 * 128), 0, 1e-4);
  EXPECT_NEAR(squares / (128 * 128), 1, 1e-3);
  NoiseField flat(4, 7);
  flat.normalise();
  EXPECT_EQ(flat.at(2, 3), 0);
}

/// The field's correlation with itself, `shift` to the right.
double correlation(const NoiseField &f, int shift) {
  double sum = 0;
  for (int y = 0; y < f.side(); ++y)
    for (int x = 0; x < f.side(); ++x) sum += static_cast<double>(f.at(x, y)) * f.at(x + shift - f.side(), y);
  return sum / f.side() / f.side();
}

TEST(NoiseField, HasBlobsOfTheRequestedSize) {
  for (const double size : {6.0, 12.0, 48.0}) {
    const NoiseField f = fractal_noise(512, {{size, 1}}, 5, 1);
    EXPECT_GT(correlation(f, static_cast<int>(size / 6)), 0.8) << size;
    EXPECT_LT(std::abs(correlation(f, static_cast<int>(2 * size))), 0.35) << size;
  }
}

TEST(NoiseField, RepeatsSeamlessly) {
  const NoiseField f = fractal_noise(64, {{10, 1}}, 5, 1);
  EXPECT_EQ(f.at(-3, 70), f.at(61, 6));
  // There is no jump from one edge to the other.
  double inside = 0, across = 0;
  for (int y = 0; y < 64; ++y) {
    inside += std::abs(f.at(31, y) - f.at(30, y));
    across += std::abs(f.at(63, y) - f.at(0, y));
  }
  EXPECT_LT(across, 2 * inside + 1);
}

TEST(NoiseField, DoublingKeepsStraightLines) {
  // Cubic B-splines reproduce straight lines. Here all is linear, except the jump at the edge.
  NoiseField f(16);
  for (int y = 0; y < 16; ++y)
    for (int x = 0; x < 16; ++x) f.row(y)[x] = static_cast<float>(3 * x);
  const NoiseField d = f.doubled();
  for (int x = 8; x < 24; ++x) EXPECT_FLOAT_EQ(d.at(x, 9), static_cast<float>(1.5 * x));
}

TEST(Cells, DivideThePlane) {
  const Cells c = cells(128, 16, 0.8, 2, 9);
  std::set<float> values;
  int borders = 0;
  for (int y = 0; y < 128; ++y)
    for (int x = 0; x < 128; ++x) {
      EXPECT_GE(c.edge.at(x, y), 0);
      EXPECT_GE(c.value.at(x, y), 0);
      EXPECT_LT(c.value.at(x, y), 1);
      values.insert(c.value.at(x, y));
      // Where the cell changes, a border is near.
      if (c.value.at(x, y) != c.value.at(x + 1 - 128, y)) {
        ++borders;
        EXPECT_LT(std::min(c.edge.at(x, y), c.edge.at(x + 1 - 128, y)), 0.13F);
      }
    }
  EXPECT_EQ(values.size(), 64U);  // 8 × 8 cells
  EXPECT_GT(borders, 1000);
}

}  // namespace
}  // namespace csd::sim
