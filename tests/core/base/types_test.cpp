// SPDX-License-Identifier: LGPL-2.1-or-later
#include "base/types.h"

#include <gtest/gtest.h>

namespace csd {
namespace {

TEST(Types, HaveTheWordsOfTheSchema) {
  EXPECT_EQ(state_name(FeatureState::learning), "learning");
  EXPECT_EQ(state_name(FeatureState::tracked), "tracked");
  EXPECT_EQ(state_name(FeatureState::occluded), "occluded");
  EXPECT_EQ(state_name(FeatureState::lost), "lost");
  EXPECT_EQ(state_name(FeatureState::out), "out");
  EXPECT_EQ(state_name(FeatureState::ended), "ended");
}

TEST(Types, OnlyLearningAndTrackedClaimAPosition) {
  EXPECT_TRUE(claims_position(FeatureState::learning));
  EXPECT_TRUE(claims_position(FeatureState::tracked));
  for (const auto state : {FeatureState::occluded, FeatureState::lost, FeatureState::out, FeatureState::ended})
    EXPECT_FALSE(claims_position(state)) << state_name(state);
}

}  // namespace
}  // namespace csd
