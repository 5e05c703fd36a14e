// SPDX-License-Identifier: LGPL-2.1-or-later
#include "sim/events.h"

#include <gtest/gtest.h>

namespace csd::sim {
namespace {

TEST(Events, ACyclicEventRisesStaysAndFalls) {
  const auto at = [](double time) { return each_cycle(time, 2, 1, 6, 2); };
  for (const double cycle : {0.0, 20.0, 400.0}) {
    EXPECT_EQ(at(cycle + 1.9), 0);
    EXPECT_DOUBLE_EQ(at(cycle + 2.5), 0.5);
    EXPECT_EQ(at(cycle + 3.5), 1);
    EXPECT_DOUBLE_EQ(at(cycle + 5), 0.5);
    EXPECT_EQ(at(cycle + 6.1), 0);
    EXPECT_EQ(at(cycle + 19.9), 0);
  }
}

TEST(Events, SmokeComesInAThickAndAThinnerBurst) {
  for (const double cycle : {0.0, 20.0}) {
    EXPECT_EQ(smoke_density(cycle + 2), 0);
    EXPECT_DOUBLE_EQ(smoke_density(cycle + 4.5), 1);
    EXPECT_EQ(smoke_density(cycle + 10), 0);
    EXPECT_DOUBLE_EQ(smoke_density(cycle + 13), 0.85);
    EXPECT_EQ(smoke_density(cycle + 19), 0);
  }
}

TEST(Events, TheSceneChangesTwiceEachCycle) {
  for (const double cycle : {0.0, 20.0}) {
    for (const double t : {3.99, 6.0, 12.99, 14.5, 19.9}) EXPECT_FALSE(is_cut(cycle + t)) << t;
    for (const double t : {4.0, 5.99, 13.0, 14.49}) EXPECT_TRUE(is_cut(cycle + t)) << t;
  }
}

TEST(Events, PulledTissueGivesWayInUnevenSteps) {
  EXPECT_EQ(stick_slip(-1, 1, 2, 3), 0);
  EXPECT_EQ(stick_slip(0, 1, 2, 3), 0);
  EXPECT_DOUBLE_EQ(stick_slip(1, 1, 2, 3), 1);
  EXPECT_DOUBLE_EQ(stick_slip(2, 1, 2, 3), 1);
  EXPECT_NE(stick_slip(0.5, 1, 2, 3), stick_slip(0.5, 1, 2, 4));
  // For half of the time hardly anything moves.
  int slow = 0;
  for (int i = 0; i < 600; ++i) {
    const double step = stick_slip((i + 1) / 600.0, 1, 2, 3) - stick_slip(i / 600.0, 1, 2, 3);
    EXPECT_GE(step, 0);
    slow += step < 0.5 / 600;
  }
  EXPECT_GT(slow, 300);
}

TEST(Events, TheFirstBlackoutBeginsAfterSixSecondsAndTheViewMovesOn) {
  EXPECT_EQ(black_out(5.99, 1).index, -1);
  EXPECT_FALSE(black_out(5.99, 1).dark);
  EXPECT_EQ(black_out(5.99, 1).moved, 0);
  for (const int k : {0, 1}) {
    const double begin = 6 + 20 * k;
    EXPECT_EQ(black_out(begin, 1).index, k);
    EXPECT_TRUE(black_out(begin, 1).dark);
    EXPECT_EQ(black_out(begin, 1).moved, 0);
    EXPECT_DOUBLE_EQ(black_out(begin + 1.25, 1).moved, 0.5);
    EXPECT_TRUE(black_out(begin + 2.49, 1).dark);
    EXPECT_FALSE(black_out(begin + 2.5, 1).dark);
    EXPECT_EQ(black_out(begin + 19.9, 1).index, k);
    EXPECT_EQ(black_out(begin + 19.9, 1).moved, 1);
  }
}

TEST(Events, ABlackoutLastsByTheRootOfItsStrength) {
  EXPECT_TRUE(black_out(7.24, 0.25).dark) << "1.25 s";
  EXPECT_FALSE(black_out(7.26, 0.25).dark);
}

TEST(Events, AClothPassesTwiceEachCycleAndLeavesAWetLens) {
  for (const double begin : {5.0, 15.0, 25.0}) {
    for (const double t : {-0.01, 2.21}) {
      EXPECT_LT(wipe_at(begin + t).cover, -0.5);
      EXPECT_EQ(wipe_at(begin + t).smear, 0);
    }
    EXPECT_DOUBLE_EQ(wipe_at(begin).cover, -0.5);
    EXPECT_EQ(wipe_at(begin).smear, 0);
    EXPECT_NEAR(wipe_at(begin + 0.3).cover, 0.5, 1e-12);
    EXPECT_NEAR(wipe_at(begin + 0.3).smear, 1, 1e-12);
    EXPECT_NEAR(wipe_at(begin + 0.6).cover, 1.5, 1e-12);
    EXPECT_NEAR(wipe_at(begin + 1.45).smear, 0.5, 1e-12);
  }
}

}  // namespace
}  // namespace csd::sim
