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
  EXPECT_EQ(algorithm_name(AlgorithmKind::csd), "csd");
  EXPECT_EQ(algorithm_name(AlgorithmKind::csd_2012), "csd-2012");
  EXPECT_EQ(algorithm_name(AlgorithmKind::csd_forest), "csd-forest");
  EXPECT_EQ(algorithm_name(AlgorithmKind::lk), "lk");
  EXPECT_EQ(algorithm_name(AlgorithmKind::ms1), "ms1");
  EXPECT_EQ(algorithm_name(AlgorithmKind::ms2), "ms2");
  EXPECT_EQ(algorithm_name(AlgorithmKind::sift), "sift");
}

TEST(Types, OnlyLearningAndTrackedClaimAPosition) {
  EXPECT_TRUE(claims_position(FeatureState::learning));
  EXPECT_TRUE(claims_position(FeatureState::tracked));
  for (const auto state : {FeatureState::occluded, FeatureState::lost, FeatureState::out, FeatureState::ended})
    EXPECT_FALSE(claims_position(state)) << state_name(state);
}

}  // namespace
}  // namespace csd
