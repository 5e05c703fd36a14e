// SPDX-License-Identifier: LGPL-2.1-or-later
#include <gtest/gtest.h>

#include <stdexcept>

#include "algorithms/make_algorithm.h"
#include "baselines/lk.h"
#include "csd/csd.h"
#include "csd2012/csd2012.h"
#include "track/algorithm.h"

namespace csd {
namespace {

class NoExecutor final : public Executor {
  void post(std::function<void()>) override { FAIL() << "nothing is learnt yet"; }
};

TEST(MakeAlgorithm, MakesTheAlgorithmThatTheSettingsName) {
  NoExecutor none;
  Settings settings;
  EXPECT_NE(dynamic_cast<Csd *>(make_algorithm(settings, none).get()), nullptr) << "the default";
  settings.algorithm = AlgorithmKind::lk;
  EXPECT_NE(dynamic_cast<LucasKanade *>(make_algorithm(settings, none).get()), nullptr);
  settings.algorithm = AlgorithmKind::csd;
  EXPECT_NE(dynamic_cast<Csd *>(make_algorithm(settings, none).get()), nullptr);
  settings.algorithm = AlgorithmKind::csd_2012;
  EXPECT_NE(dynamic_cast<Csd2012 *>(make_algorithm(settings, none).get()), nullptr);
  settings.algorithm = AlgorithmKind::csd_forest;
  EXPECT_NE(dynamic_cast<Csd2012 *>(make_algorithm(settings, none).get()), nullptr);
}

TEST(MakeAlgorithm, RefusesAnUnknownAlgorithm) {
  NoExecutor none;
  Settings settings;
  settings.algorithm = static_cast<AlgorithmKind>(99);
  EXPECT_THROW(make_algorithm(settings, none), std::invalid_argument);
}

// §2.1: the paper's tracker replaces no lost feature, and neither do the trackers it is compared with.
TEST(MakeAlgorithm, NoneReplacesLostFeatures) {
  NoExecutor none;
  Settings settings;
  for (const auto kind : {AlgorithmKind::csd_2012, AlgorithmKind::csd_forest, AlgorithmKind::lk, AlgorithmKind::ms1,
                          AlgorithmKind::ms2, AlgorithmKind::sift}) {
    settings.algorithm = kind;
    EXPECT_FALSE(make_algorithm(settings, none)->replenishes()) << algorithm_name(kind);
    EXPECT_FALSE(make_algorithm(settings, none)->avoids_tools()) << algorithm_name(kind);
  }
}

}  // namespace
}  // namespace csd
