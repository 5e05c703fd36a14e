// SPDX-License-Identifier: LGPL-2.1-or-later
#include "track/stream_clock.h"

#include <algorithm>
#include <limits>

namespace csd {

namespace {

/// 73 years, the limit for damaged stamps: sums and differences of times do not overflow.
constexpr std::int64_t latest = std::numeric_limits<std::int64_t>::max() / 4;

std::int64_t difference(std::int64_t a, std::int64_t b) {
  std::int64_t result;
  if (!__builtin_sub_overflow(a, b, &result)) return result;
  return a > b ? std::numeric_limits<std::int64_t>::max() : std::numeric_limits<std::int64_t>::min();
}

}  // namespace

void StreamClock::advance(std::int64_t pts, std::int64_t duration, bool discont) {
  const auto step = last_duration_ > 0 ? std::min(last_duration_, latest) : nominal_duration;
  const bool stamped = pts != no_time && last_pts_ != no_time;
  if (any_) {
    const std::int64_t ahead = difference(pts, last_pts_);
    time_ = std::min(time_ + std::min(stamped && pts > last_pts_ ? ahead : step, latest), latest);
    const bool jumps = stamped && (ahead > step + min_jump || ahead < step - min_jump);
    const bool some_left_out = stamped && !jumps && ahead > step + step / 2;
    jumped_ |= jumps || (discont && !some_left_out);
  }
  any_ = true;
  last_pts_ = pts;
  last_duration_ = duration;
}

}  // namespace csd
