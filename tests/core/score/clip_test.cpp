// SPDX-License-Identifier: LGPL-2.1-or-later
#include "score/clip.h"

#include <gtest/gtest.h>

#include <utility>

#include "samples.h"

namespace csd::score {
namespace {

TEST(Clip, TheToleranceGrowsAbove576Lines) {
  EXPECT_DOUBLE_EQ(tolerance(240, 4), 4);
  EXPECT_DOUBLE_EQ(tolerance(576, 4), 4);
  EXPECT_DOUBLE_EQ(tolerance(1080, 4), 7.5);
  EXPECT_DOUBLE_EQ(tolerance(1152, 5), 10);
}

TEST(Clip, ASampleHoldsItsDistanceAndTheTruth) {
  EXPECT_EQ(Sample().distance(), std::numeric_limits<double>::infinity());
  EXPECT_FALSE(Sample().labelled());
  EXPECT_DOUBLE_EQ(seen(3, -4).distance(), 5);
  EXPECT_TRUE(seen(0).labelled() && seen(0).visible());
  for (const auto presence : {Presence::hidden, Presence::out}) {
    EXPECT_TRUE(quiet(presence).labelled());
    EXPECT_FALSE(quiet(presence).visible());
  }
}

TEST(Clip, AFeaturesSamplesAreContiguous) {
  Clip clip = clip_of(64, 48, {{seen(1), seen(2), seen(3)}, {seen(4), seen(5), seen(6)}});
  EXPECT_EQ(clip.at(0, 2).dx, 3);
  EXPECT_EQ(clip.at(1, 0).dx, 4);
  clip.at(1, 2).dx = 9;
  EXPECT_EQ(std::as_const(clip).at(1, 2).dx, 9);
  EXPECT_EQ(clip.samples[5].dx, 9);
}

}  // namespace
}  // namespace csd::score
