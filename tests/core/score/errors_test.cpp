// SPDX-License-Identifier: LGPL-2.1-or-later
#include "score/errors.h"

#include <gtest/gtest.h>

#include "score/samples.h"

namespace csd::score {
namespace {

TEST(Errors, CountClaimsOnVisibleFeatures) {
  const Clip clip = clip_of(640, 480, {{seen(3, 4), missed(9), ghost()}, {seen(0, -2), unlabelled(), seen(1)}});
  EXPECT_EQ(claimed_errors(clip), (std::vector<double>{5, 2, 1}));
  EXPECT_EQ(claimed_errors(clip, 0, 1), (std::vector<double>{5, 2}));
}

TEST(Errors, DriftComparesTheFirstAndTheLastFifth) {
  // 6 frames: a fifth, rounded up, is 2.
  const Clip clip = clip_of(640, 480, {{seen(1), seen(2), seen(3), seen(4), seen(5), seen(7)}});
  const DriftErrors drift = drift_errors(clip);
  EXPECT_EQ(drift.first, (std::vector<double>{1, 2}));
  EXPECT_EQ(drift.last, (std::vector<double>{5, 7}));
  // 5 frames: one.
  const DriftErrors five = drift_errors(clip_of(640, 480, {{seen(1), seen(2), seen(3), seen(4), seen(5)}}));
  EXPECT_EQ(five.first, (std::vector<double>{1}));
  EXPECT_EQ(five.last, (std::vector<double>{5}));
}

}  // namespace
}  // namespace csd::score
