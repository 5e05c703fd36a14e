// SPDX-License-Identifier: LGPL-2.1-or-later
#include "score/types.h"

#include <gtest/gtest.h>

namespace csd::score {
namespace {

TEST(ScoreTypes, AnErrorNamesTheFileAndTheLineWhereThereIsOne) {
  EXPECT_STREQ(InputError("a.csv", 12, "is torn").what(), "a.csv:12: is torn");
  EXPECT_STREQ(InputError("a.csv", 0, "is empty").what(), "a.csv: is empty");
}

}  // namespace
}  // namespace csd::score
