// SPDX-License-Identifier: LGPL-2.1-or-later
#include "csd/visibility.h"

#include <gtest/gtest.h>

#include <cmath>

namespace csd {
namespace {

/// A feature under good conditions.
Evidence good() {
  Evidence e;
  e.zncc_fine = e.zncc_coarse = 0.98;
  e.centre = 0.97;
  e.unmasked = 1;
  e.noise = 0.5;
  e.disagreement = 0.2;
  e.contrast = 15;
  e.self_similarity = 0.6;
  return e;
}

TEST(Visibility, IsHighWhenEverythingFits) {
  EXPECT_GT(visibility(good(), {}), 0.98);
}

TEST(Visibility, FallsWithEachContraryEvidence) {
  const double best = visibility(good(), {});
  const auto worse = [&](auto change) {
    auto e = good();
    change(e);
    return visibility(e, {}) < best;
  };
  EXPECT_TRUE(worse([](Evidence &e) { e.zncc_coarse = 0.3; }));
  EXPECT_TRUE(worse([](Evidence &e) { e.zncc_fine = 0.3; }));
  EXPECT_TRUE(worse([](Evidence &e) { e.self_similarity = 0.95; }));
  EXPECT_TRUE(worse([](Evidence &e) { e.gain = 0.2; }));
  EXPECT_TRUE(worse([](Evidence &e) { e.unmasked = 0.4; }));
  EXPECT_TRUE(worse([](Evidence &e) { e.disagreement = 3; }));
  EXPECT_TRUE(worse([](Evidence &e) { e.noise = 20; }));
  EXPECT_TRUE(worse([](Evidence &e) { e.centre = 0; }));
  EXPECT_TRUE(worse([](Evidence &e) { e.brightness_change = 50; }));
  EXPECT_TRUE(worse([](Evidence &e) { e.brightness_change = -50; }));
}

TEST(Visibility, IsLowWhenNothingFits) {
  Evidence e;
  e.unmasked = 0.3;
  e.gain = 0.08;
  e.noise = 60;
  e.disagreement = 4;
  EXPECT_LT(visibility(e, {}), 0.1);
}

TEST(Visibility, IsAlwaysAProbability) {
  for (const double zncc : {-1.0, 1.0})
    for (const double gain : {0.08, 10.0}) {
      auto e = good();
      e.zncc_fine = e.zncc_coarse = zncc;
      e.gain = gain;
      e.noise = 1e6;
      e.disagreement = e.brightness_change = 1e6;
      const double p = visibility(e, {});
      EXPECT_TRUE(p >= 0 && p <= 1) << p;
    }
}

}  // namespace
}  // namespace csd
