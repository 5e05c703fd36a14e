// SPDX-License-Identifier: LGPL-2.1-or-later
#include "detect/candidate.h"

#include <gtest/gtest.h>

namespace {

TEST(Candidates, AreRankedByStrengthThenRowThenColumn) {
  csd::Candidates candidates{{{7, 3}, 1}, {{2, 9}, 2}, {{5, 3}, 1}, {{9, 1}, 1}, {{0, 0}, 0.5F}};
  csd::rank(candidates);
  const std::vector<cv::Point2d> expected{{2, 9}, {9, 1}, {5, 3}, {7, 3}, {0, 0}};
  ASSERT_EQ(candidates.size(), expected.size());
  for (std::size_t i = 0; i < expected.size(); ++i) EXPECT_EQ(candidates[i].at, expected[i]) << i;
}

}  // namespace
