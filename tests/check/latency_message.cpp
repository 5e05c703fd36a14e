// SPDX-License-Identifier: LGPL-2.1-or-later
#include <gtest/gtest.h>

#include "meta/message.h"
#include "support/latency.h"

namespace {

TEST(Latency, PercentileIsAtMostASixteenthTooHigh) {
  csd::Latency latency;
  EXPECT_EQ(latency.quantile(0.5), 0u);
  for (std::uint64_t ns = 1; ns <= 100000; ++ns) latency.add(ns);
  for (const auto &[q, exact] : {std::pair{0.5, 50000.}, {0.95, 95000.}, {0.0001, 10.}}) {
    EXPECT_GE(static_cast<double>(latency.quantile(q)), exact);
    EXPECT_LE(static_cast<double>(latency.quantile(q)), exact * (1 + 1 / 16.) + 1);
  }
  EXPECT_EQ(latency.quantile(1), 100000u);
  EXPECT_EQ(latency.max(), 100000u);
  latency.add(~std::uint64_t{0});
  EXPECT_EQ(latency.quantile(1), ~std::uint64_t{0});
}

TEST(MessageGate, AChangeWithinTheIntervalIsPostedAtItsEnd) {
  csd::MessageGate gate;
  const auto change = GST_CSD_TRACK_POST_MESSAGES_CHANGE;
  EXPECT_TRUE(gate.due(change, 100, true, 0));
  EXPECT_FALSE(gate.due(change, 100, true, 40));
  EXPECT_FALSE(gate.due(change, 100, false, 80));
  EXPECT_TRUE(gate.due(change, 100, false, 120));
  EXPECT_FALSE(gate.due(change, 100, false, 300));
  EXPECT_TRUE(gate.due(change, 100, true, 10)) << "time went back";
  EXPECT_TRUE(gate.due(change, 100, true, GST_CLOCK_TIME_NONE));
  EXPECT_FALSE(gate.due(GST_CSD_TRACK_POST_MESSAGES_NONE, 0, true, 900));
  EXPECT_FALSE(gate.due(change, 0, false, 901)) << "changes are dropped while posting is off";
}

}  // namespace
