// SPDX-License-Identifier: LGPL-2.1-or-later
#include "track/frame_budget.h"

#include <gtest/gtest.h>

namespace csd {
namespace {

TEST(FrameBudget, IsSpentAfterItsEnd) {
  std::int64_t now = 500;
  const FrameBudget::Clock clock = [&now] { return now; };
  const FrameBudget whole(100, clock), half = whole.share(0.5);
  EXPECT_TRUE(whole.limited() && half.limited());
  now = 549;
  EXPECT_FALSE(half.spent());
  now = 550;
  EXPECT_TRUE(half.spent());
  EXPECT_FALSE(whole.spent());
  now = 600;
  EXPECT_TRUE(whole.spent());
}

TEST(FrameBudget, WithoutABudgetNothingIsSpentAndNoClockIsRead) {
  const FrameBudget::Clock clock = [] {
    ADD_FAILURE();
    return std::int64_t{0};
  };
  const FrameBudget none(0, clock);
  EXPECT_FALSE(none.limited() || none.spent() || none.share(0.1).spent() || FrameBudget().spent());
}

TEST(FrameBudget, ATinyShareIsStillABudget) {
  std::int64_t now = 0;
  const FrameBudget::Clock clock = [&now] { return now; };
  const auto share = FrameBudget(1, clock).share(0.1);
  EXPECT_FALSE(share.spent());
  now = 1;
  EXPECT_TRUE(share.spent());
}

}  // namespace
}  // namespace csd
