// SPDX-License-Identifier: LGPL-2.1-or-later
#include "patch/affine_state.h"

#include <gtest/gtest.h>

namespace csd {
namespace {

TEST(AffineState, TheScaleIsTheRootOfTheAreaRatio) {
  EXPECT_DOUBLE_EQ(AffineState{}.scale(), 1);
  EXPECT_DOUBLE_EQ((AffineState{{5, 6}, {2, 1, 0, 8}}.scale()), 4);
  EXPECT_DOUBLE_EQ((AffineState{{5, 6}, {0, -3, 3, 0}}.scale()), 3);
}

}  // namespace
}  // namespace csd
