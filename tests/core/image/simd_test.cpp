// SPDX-License-Identifier: LGPL-2.1-or-later
#include "image/simd.h"

#include <gtest/gtest.h>
#include <hwy/highway.h>

namespace csd {
namespace {

TEST(Simd, IsTheBestTargetOfTheMachine) {
  const auto best_first = hwy::SupportedAndGeneratedTargets();
  ASSERT_FALSE(best_first.empty());
  EXPECT_STREQ(simd_target(), hwy::TargetName(best_first.front()));
}

}  // namespace
}  // namespace csd
