// SPDX-License-Identifier: LGPL-2.1-or-later
#include "score/jaccard.h"

#include <gtest/gtest.h>

#include "score/samples.h"

namespace csd::score {
namespace {

TEST(Jaccard, SumsAddUpWithTheirMultiples) {
  constexpr Thresholds thresholds{1, 2, 3, 4, 5};
  JaccardSums one, many;
  one.add(seen(2), 2, thresholds);
  one.add(ghost(), 0, thresholds);
  many.add(one);
  many.add(one, 3);
  EXPECT_EQ(many.evaluated, 8u);
  EXPECT_EQ(many.agreed, 4u);
  EXPECT_EQ(many.visible, 4u);
  EXPECT_EQ(many.within, (std::array<std::uint64_t, 5>{0, 0, 4, 4, 4})) << "2 is not below 2";
  EXPECT_EQ(many.true_positive, many.within);
  EXPECT_EQ(many.false_positive, (std::array<std::uint64_t, 5>{8, 8, 4, 4, 4}));
}

TEST(Jaccard, AWrongClaimCountsTwice) {
  JaccardSums sums;
  sums.add(seen(9), 9, {1, 2, 3, 4, 5});
  sums.add(seen(0), 0, {1, 2, 3, 4, 5});
  EXPECT_DOUBLE_EQ(jaccard_score(sums).aj, 1. / 3) << "1 right of 2 visible and 1 false";
}

}  // namespace
}  // namespace csd::score
