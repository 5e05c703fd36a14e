// SPDX-License-Identifier: LGPL-2.1-or-later
#include "track/stream_clock.h"

#include <cstdlib>

namespace csd {

void StreamClock::advance(std::int64_t pts, std::int64_t duration, bool discont) {
  const auto step = last_duration_ > 0 ? last_duration_ : nominal_duration;
  const bool stamped = pts != no_time && last_pts_ != no_time;
  if (any_) {
    time_ += stamped && pts > last_pts_ ? pts - last_pts_ : step;
    jumped_ |= discont || (stamped && std::abs(pts - last_pts_ - step) > least_jump);
  }
  any_ = true;
  last_pts_ = pts;
  last_duration_ = duration;
}

}  // namespace csd
