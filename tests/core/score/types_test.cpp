// SPDX-License-Identifier: LGPL-2.1-or-later
#include "score/types.h"

#include <gtest/gtest.h>

namespace csd::score {
namespace {

TEST(ScoreTypes, AnErrorNamesTheFileAndTheLineWhereThereIsOne) {
  EXPECT_STREQ(InputError("a.csv", 12, "is torn").what(), "a.csv:12: is torn");
  EXPECT_STREQ(InputError("a.csv", 0, "is empty").what(), "a.csv: is empty");
}

TEST(ScoreTypes, OnlyLearningAndTrackedClaimAPosition) {
  EXPECT_TRUE(claims_position(FeatureState::learning));
  EXPECT_TRUE(claims_position(FeatureState::tracked));
  for (const auto state : {FeatureState::occluded, FeatureState::lost, FeatureState::out, FeatureState::ended})
    EXPECT_FALSE(claims_position(state)) << static_cast<int>(state);
}

}  // namespace
}  // namespace csd::score
