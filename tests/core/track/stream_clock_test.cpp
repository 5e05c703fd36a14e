// SPDX-License-Identifier: LGPL-2.1-or-later
#include "track/stream_clock.h"

#include <gtest/gtest.h>

#include <limits>

namespace csd {
namespace {

constexpr std::int64_t ms = second / 1000;

TEST(StreamClock, UsesTimestampsElseDurations) {
  StreamClock clock;
  clock.advance(7000 * ms, 33 * ms, false);
  EXPECT_EQ(clock.time(), 0);
  clock.advance(7050 * ms, 20 * ms, false);
  EXPECT_EQ(clock.time(), 50 * ms);
  clock.advance(no_time, no_time, false);
  EXPECT_EQ(clock.time(), 70 * ms);
  clock.advance(100 * ms, 33 * ms, false);  // no previous timestamp and no duration: 40 ms
  EXPECT_EQ(clock.time(), 110 * ms);
  clock.advance(90 * ms, 33 * ms, false);  // backwards
  EXPECT_EQ(clock.time(), 143 * ms);
  EXPECT_FALSE(clock.jumped());
}

TEST(StreamClock, TheFirstFrameIsNoJump) {
  StreamClock clock;
  clock.advance(7000 * ms, 40 * ms, true);
  EXPECT_FALSE(clock.jumped());
}

TEST(StreamClock, FramesDroppedByAQueueAreNoJumpButACutIs) {
  const auto jumps = [](std::int64_t pts) {
    StreamClock clock;
    clock.advance(10 * second, 40 * ms, false);
    clock.advance(pts, 40 * ms, true);
    return clock.jumped();
  };
  EXPECT_FALSE(jumps(10080 * ms)) << "one frame dropped";
  EXPECT_FALSE(jumps(10540 * ms)) << "a dozen frames dropped";
  EXPECT_TRUE(jumps(10541 * ms));
  EXPECT_TRUE(jumps(10040 * ms)) << "none dropped, so it is a cut";
  EXPECT_TRUE(jumps(10050 * ms));
  EXPECT_TRUE(jumps(9 * second));
  EXPECT_TRUE(jumps(no_time));
}

TEST(StreamClock, JumpsByMoreThanHalfASecondFromTheExpectedTimestamp) {
  const auto jumps = [](std::int64_t duration, std::int64_t pts) {
    StreamClock clock;
    clock.advance(10 * second, duration, false);
    clock.advance(pts, duration, false);
    return clock.jumped();
  };
  EXPECT_FALSE(jumps(40 * ms, 10540 * ms));
  EXPECT_TRUE(jumps(40 * ms, 10541 * ms));
  EXPECT_FALSE(jumps(second, 11 * second)) << "a frame that lasts a second";
  EXPECT_FALSE(jumps(no_time, 10540 * ms)) << "40 ms";
  EXPECT_TRUE(jumps(no_time, 10541 * ms));
  EXPECT_FALSE(jumps(40 * ms, 9540 * ms));
  EXPECT_TRUE(jumps(40 * ms, 9539 * ms));
}

// Each of these would overflow 64 bits. Only a sanitizer sees that, or a time that goes back.
TEST(StreamClock, AcceptsDamagedTimestamps) {
  constexpr auto most = std::numeric_limits<std::int64_t>::max();
  StreamClock clock;
  std::int64_t last = 0;
  for (const std::int64_t pts : {std::int64_t{0}, most, std::int64_t{0}, most, -most, most}) {
    clock.advance(pts, most, false);
    EXPECT_GE(clock.time(), last);
    last = clock.time();
  }
  EXPECT_TRUE(clock.jumped());
}

TEST(StreamClock, AJumpLastsUntilAFrameIsSeen) {
  StreamClock clock;
  clock.advance(0, 40 * ms, false);
  clock.advance(40 * ms, 40 * ms, true);
  clock.advance(80 * ms, 40 * ms, false);
  EXPECT_TRUE(clock.jumped());
  clock.seen();
  clock.advance(120 * ms, 40 * ms, false);
  EXPECT_FALSE(clock.jumped());
}

}  // namespace
}  // namespace csd
