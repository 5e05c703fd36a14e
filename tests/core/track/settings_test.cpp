// SPDX-License-Identifier: LGPL-2.1-or-later
#include "track/settings.h"

#include <gtest/gtest.h>

namespace csd {
namespace {

TEST(Settings, AlgorithmsHaveTheWordsOfTheProperty) {
  EXPECT_EQ(algorithm_name(AlgorithmKind::csd), "csd");
  EXPECT_EQ(algorithm_name(AlgorithmKind::csd_2012), "csd-2012");
  EXPECT_EQ(algorithm_name(AlgorithmKind::csd_forest), "csd-forest");
  EXPECT_EQ(algorithm_name(AlgorithmKind::lk), "lk");
  EXPECT_EQ(algorithm_name(AlgorithmKind::ms1), "ms1");
  EXPECT_EQ(algorithm_name(AlgorithmKind::ms2), "ms2");
  EXPECT_EQ(algorithm_name(AlgorithmKind::sift), "sift");
}

}  // namespace
}  // namespace csd
