// SPDX-License-Identifier: LGPL-2.1-or-later
#include "score/errors.h"

#include <gtest/gtest.h>

#include "score/quantile.h"
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

TEST(Quantile, InterpolatesBetweenNeighbours) {
  EXPECT_EQ(quantile({4, 1, 3, 2}, 0.5), 2.5);
  EXPECT_EQ(quantile({5, 1, 3}, 0.5), 3);
  EXPECT_NEAR(quantile({0, 10, 20, 30, 40}, 0.95), 38, 1e-12);  // at 3.8
  EXPECT_EQ(quantile({7}, 0.95), 7);
  EXPECT_EQ(quantile({3, 9}, 1), 9);
  EXPECT_TRUE(std::isnan(quantile({}, 0.5)));
}

TEST(Quantile, ValuesMayBeInfinite) {
  const double infinite = std::numeric_limits<double>::infinity();
  EXPECT_EQ(quantile({infinite, 1, infinite, infinite}, 0.5), infinite);
  EXPECT_EQ(quantile({infinite, 1, 2}, 0.5), 2);
}

TEST(MeanOfKnown, LeavesOutUnknownValues) {
  EXPECT_EQ(mean_of_known({1, unknown, 4}), 2.5);
  EXPECT_TRUE(std::isnan(mean_of_known({unknown})));
}

}  // namespace
}  // namespace csd::score
