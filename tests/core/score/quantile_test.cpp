// SPDX-License-Identifier: LGPL-2.1-or-later
#include "score/quantile.h"

#include <gtest/gtest.h>

namespace csd::score {
namespace {

constexpr double infinite = std::numeric_limits<double>::infinity();

TEST(Quantile, InterpolatesBetweenNeighbours) {
  const std::vector<double> values{3, 1, 4, 2};
  EXPECT_DOUBLE_EQ(quantile(values, 0), 1);
  EXPECT_DOUBLE_EQ(quantile(values, 0.25), 1.75);
  EXPECT_DOUBLE_EQ(quantile(values, 0.5), 2.5);
  EXPECT_DOUBLE_EQ(quantile(values, 0.9), 3.7);
  EXPECT_DOUBLE_EQ(quantile(values, 1), 4);
  EXPECT_DOUBLE_EQ(quantile({7}, 0.3), 7);
  EXPECT_TRUE(std::isnan(quantile({}, 0.5)));
}

TEST(Quantile, InfiniteValuesAreTheLargestAndNeverGiveNan) {
  EXPECT_EQ(quantile({infinite, 1, 2}, 0.5), 2);
  EXPECT_EQ(quantile({infinite, 1, 2}, 0.75), infinite);
  EXPECT_EQ(quantile({infinite, infinite, infinite}, 0.25), infinite) << "not ∞ − ∞";
}

TEST(Quantile, TheMeanLeavesOutUnknownValues) {
  EXPECT_DOUBLE_EQ(mean_of_known({1, unknown, 4}), 2.5);
  EXPECT_TRUE(std::isnan(mean_of_known({unknown, unknown})));
  EXPECT_TRUE(std::isnan(mean_of_known({})));
}

}  // namespace
}  // namespace csd::score
