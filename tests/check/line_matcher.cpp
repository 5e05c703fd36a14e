// SPDX-License-Identifier: LGPL-2.1-or-later
#include "record/line_matcher.h"

#include <gtest/gtest.h>

#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace {

constexpr std::int64_t ms = 1000000, step = 40 * ms;

/// A line's or a frame's number says whose it is: 100 times its part, and its place in it.
struct Matched : csd::LineMatcher {
  void line(int number, std::int64_t time, csd::TimeBase base = csd::TimeBase::running) {
    csd::TrackLine line{};
    line.tracks.frame = static_cast<std::uint64_t>(number);
    add({time, std::move(line), base});
  }
  void lines(int part, int from, int to, std::int64_t offset = 0) {
    for (int n = from; n < to; ++n) line(100 * part + n, n * step + offset);
  }
  /// Shows a frame. Lines are then added by the test.
  void at(std::int64_t running, std::int64_t stream = 0) {
    frame({csd::FrameMoment{running, 0, step / 2}, csd::FrameMoment{stream, 0, step / 2}});
  }
  /// The current frame's line, −1 without one, −2 if a later line could be it.
  int decide() {
    if (!decided()) return -2;
    return taken();
  }
  int taken() {
    const auto line = take();
    return line ? static_cast<int>(line->tracks.frame) : -1;
  }
  int on(int n) {
    at(n * step, n * step);
    return taken();
  }
};

TEST(LineMatcher, NearestWithinHalfAFrame) {
  Matched m;
  m.line(1, 60 * ms);
  m.line(2, 70 * ms);
  m.line(3, 91 * ms);
  m.line(4, 200 * ms);
  m.at(80 * ms);
  EXPECT_EQ(m.taken(), 2);
  m.at(111 * ms);
  EXPECT_EQ(m.taken(), 3) << "half a frame";
  m.at(179 * ms);
  EXPECT_EQ(m.decide(), -1) << "more than half a frame";
  m.at(180 * ms);
  EXPECT_EQ(m.taken(), 4);
  EXPECT_EQ(m.taken(), -1) << "each line once";
}

TEST(LineMatcher, TheEarlierOfTwoEquallyNear) {
  Matched m;
  m.line(1, 70 * ms);
  m.line(2, 90 * ms);
  m.at(80 * ms);
  EXPECT_EQ(m.taken(), 1);
}

TEST(LineMatcher, WhatDecides) {
  Matched m;
  m.at(80 * ms);
  EXPECT_FALSE(m.decided()) << "nothing has come";
  m.line(1, 70 * ms);
  EXPECT_FALSE(m.decided()) << "a nearer one may come";
  m.line(2, 90 * ms);
  EXPECT_EQ(m.decide(), 1);

  Matched exact;
  exact.at(80 * ms);
  exact.line(1, 80 * ms);
  EXPECT_EQ(exact.decide(), 1);

  Matched beyond;
  beyond.at(80 * ms);
  beyond.line(1, 100 * ms);
  EXPECT_EQ(beyond.decide(), 1) << "within reach, and none that comes is nearer";
  beyond.at(40 * 80 * ms);
  beyond.line(2, 40 * 80 * ms + 21 * ms);
  EXPECT_EQ(beyond.decide(), -1);
}

TEST(LineMatcher, AGapDecides) {
  Matched m;
  m.at(80 * ms);
  m.no_line(0, 100 * ms);
  EXPECT_FALSE(m.decided()) << "a line at its end is within reach";
  m.no_line(100 * ms, 100 * ms + 1);
  EXPECT_EQ(m.decide(), -1);
}

TEST(LineMatcher, AFrameWithoutTimesWaitsForNothing) {
  Matched m;
  m.frame({});
  EXPECT_EQ(m.decide(), -1);
}

TEST(LineMatcher, AClippedFrameIsMatchedByItsWhole) {
  Matched m;
  m.line(1, 80 * ms);
  m.line(2, 120 * ms);
  m.frame({csd::FrameMoment{115 * ms, 35 * ms, step / 2}, std::nullopt});
  EXPECT_EQ(m.taken(), 1);
}

TEST(LineMatcher, AFrameThatSeemsClippedHasItsOwnLine) {
  Matched m;
  m.frame({csd::FrameMoment{100 * ms, 20 * ms, step / 2}, std::nullopt});
  m.line(1, 80 * ms);
  m.line(2, 90 * ms);
  EXPECT_FALSE(m.decided()) << "a nearer one may come";
  m.line(3, 100 * ms);
  EXPECT_EQ(m.decide(), 3);
  EXPECT_EQ(m.taken(), 2) << "the last of the others";
}

/// Both sides start again at 0 without a flush. Which side begins first, and what each of them lacks.
struct Laps {
  const char *what;
  bool lines_first;
  int lines_1_to, lines_2_from, frames_1_to, frames_2_from;
};

TEST(LineMatcher, NoLineIsOnAnotherLapsFrame) {
  const Laps cases[] = {
      {"the lines run ahead", true, 5, 0, 5, 0},
      {"the frames run ahead", false, 5, 0, 5, 0},
      {"the lines run ahead, some left over", true, 8, 0, 5, 0},
      {"the frames run ahead, some lines left over", false, 8, 0, 5, 0},
      {"the lines run ahead, frames without lines at the end", true, 3, 0, 5, 0},
      {"the frames run ahead, frames without lines at the end", false, 3, 0, 5, 0},
      {"the lines run ahead, part 2's begin late", true, 5, 2, 5, 0},
      {"the frames run ahead, part 2's lines begin late", false, 5, 2, 5, 0},
      {"the lines run ahead, part 2's frames begin late", true, 5, 0, 5, 2},
      {"the frames run ahead, part 2's frames begin late", false, 5, 0, 5, 2},
  };
  for (const Laps &c : cases) {
    Matched m;
    const auto check = [&](int part, int n) {
      const int number = m.taken(), lines_to = part == 1 ? c.lines_1_to : 5,
                lines_from = part == 1 ? 0 : c.lines_2_from;
      EXPECT_EQ(number, n >= lines_from && n < lines_to ? 100 * part + n : -1)
          << c.what << ", part " << part << ", frame " << n;
    };
    // As the element reads: lines come once a frame needs them.
    std::vector<std::pair<int, int>> coming;
    for (int n = 0; n < c.lines_1_to; ++n) coming.emplace_back(1, n);
    for (int n = c.lines_2_from; n < 5; ++n) coming.emplace_back(2, n);
    std::size_t next = 0;
    const auto read = [&](bool one_more) {
      while (next < coming.size() && (one_more || !m.decided())) {
        one_more = false;
        if (next > 0 && coming[next].first != coming[next - 1].first) m.lines_begin();
        m.line(100 * coming[next].first + coming[next].second, coming[next].second * step);
        ++next;
      }
    };
    for (int n = 0; n < c.frames_1_to; ++n) {
      m.at(n * step, n * step);
      read(c.lines_first && n == c.frames_1_to - 1);
      check(1, n);
    }
    m.frames_begin();
    for (int n = c.frames_2_from; n < 5; ++n) {
      m.at(n * step, n * step);
      read(false);
      check(2, n);
    }
  }
}

TEST(LineMatcher, LinesThatBeganAgainWaitForTheFrames) {
  Matched m;
  m.lines(1, 0, 3);
  for (int n = 0; n < 3; ++n) EXPECT_EQ(m.on(n), 100 + n);
  m.lines_begin();
  m.at(3 * step);
  m.lines(2, 0, 5);
  EXPECT_EQ(m.decide(), -1);
  EXPECT_TRUE(m.lines_ahead());
  EXPECT_EQ(m.on(4), -1) << "of the other lap";
  m.frames_begin();
  for (int n = 0; n < 5; ++n) EXPECT_EQ(m.on(n), 200 + n);
  EXPECT_FALSE(m.lines_ahead());
}

TEST(LineMatcher, FramesThatBeganAgainDropTheOldLines) {
  Matched m;
  m.lines(1, 0, 8);
  for (int n = 0; n < 5; ++n) EXPECT_EQ(m.on(n), 100 + n);
  m.frames_begin();
  m.at(0, 0);
  EXPECT_EQ(m.decide(), -2) << "waits for lines of its own";
  m.lines(1, 8, 10);
  EXPECT_EQ(m.decide(), -2) << "still the old ones";
  m.lines_begin();
  m.lines(2, 0, 5);
  EXPECT_EQ(m.taken(), 200);
  for (int n = 1; n < 5; ++n) EXPECT_EQ(m.on(n), 200 + n);
}

TEST(LineMatcher, ANewSegmentThatGoesOnIsTheSameLap) {
  // As concat does it: the base grows.
  Matched m;
  for (int part = 1; part < 4; ++part) {
    if (part > 1) m.lines_begin();
    m.lines(part, 0, 5, part * 5 * step);
  }
  for (int part = 1; part < 4; ++part) {
    if (part > 1) m.frames_begin();
    for (int n = 0; n < 5; ++n) {
      m.at((part * 5 + n) * step, n * step);
      EXPECT_EQ(m.taken(), 100 * part + n);
    }
  }
}

TEST(LineMatcher, ASparseSecondPartBeginsWithAGap) {
  Matched m;
  m.lines(1, 0, 5);
  for (int n = 0; n < 5; ++n) EXPECT_EQ(m.on(n), 100 + n);
  m.lines_begin();
  m.no_line(0, 3 * step);
  m.line(203, 3 * step);
  m.frames_begin();
  for (int n = 0; n < 5; ++n) EXPECT_EQ(m.on(n), n == 3 ? 203 : -1) << n;
}

TEST(LineMatcher, RepeatedLinesOfANewLinkReplaceThoseFromTheFirstOn) {
  Matched m;
  m.lines(1, 0, 6);
  EXPECT_EQ(m.on(0), 100);
  m.lines_begin_anew(true);
  m.lines(2, 3, 8);
  for (int n = 1; n < 8; ++n) EXPECT_EQ(m.on(n), n < 3 ? 100 + n : 200 + n);
  EXPECT_FALSE(m.lines_ahead());
}

TEST(LineMatcher, ANewLinkMayGoBack) {
  Matched m;
  m.lines(1, 0, 6);
  for (int n = 0; n < 6; ++n) EXPECT_EQ(m.on(n), 100 + n);
  m.lines_begin_anew(true);
  m.lines(2, 2, 9);
  EXPECT_FALSE(m.lines_ahead()) << "it belongs to the frames as they are";
  for (int n = 6; n < 9; ++n) EXPECT_EQ(m.on(n), 200 + n);
}

TEST(LineMatcher, AFlushOfTheLinesForgetsThem) {
  Matched m;
  m.lines(1, 0, 9);
  EXPECT_EQ(m.on(0), 100);
  m.lines_begin_anew(false);
  m.at(step, step);
  EXPECT_EQ(m.decide(), -2);
  m.lines(2, 0, 5);
  EXPECT_EQ(m.taken(), 201);
  EXPECT_EQ(m.on(2), 202);
}

TEST(LineMatcher, AFlushOfTheFramesKeepsTheLines) {
  Matched m;
  m.lines(1, 0, 9);
  for (int n = 0; n < 3; ++n) EXPECT_EQ(m.on(n), 100 + n);
  m.frames_begin_anew();
  m.frames_begin();
  for (int n = 4; n < 9; ++n) EXPECT_EQ(m.on(n), 100 + n);
}

TEST(LineMatcher, ByteStreamsAreMatchedByStreamTime) {
  Matched m;
  for (int n = 0; n < 5; ++n) m.line(100 + n, n * step, csd::TimeBase::stream);
  for (int n = 0; n < 5; ++n) {
    m.at(100 * step + n * step, n * step);
    EXPECT_EQ(m.taken(), 100 + n);
  }
  // The video plays again, and then another text comes; the running time grows.
  m.frames_begin();
  m.at(200 * step, 0);
  EXPECT_EQ(m.decide(), -2);
  m.lines_begin();
  for (int n = 0; n < 5; ++n) m.line(200 + n, n * step, csd::TimeBase::stream);
  EXPECT_EQ(m.taken(), 200);
  for (int n = 1; n < 5; ++n) {
    m.at((200 + n) * step, n * step);
    EXPECT_EQ(m.taken(), 200 + n);
  }
}

}  // namespace
