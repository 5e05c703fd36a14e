// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <cstdint>

#include "track/types.h"

namespace csd {

/// The time of a stream's frames, by their stamps where these make sense, else by durations: a gap in the stamps never
/// stops it, and it never goes back.
class StreamClock {
 public:
  static constexpr std::int64_t nominal_duration = second / 25;  ///< of a frame, where the stream does not say
  static constexpr std::int64_t min_jump = second / 2;           ///< of the stamps, against where they were to go on

  /// The next frame. `pts`, `duration` in ns, no_time where unknown; `discont`: it does not follow on the last one.
  /// Where the stamps say that less than min_jump is missing in between that is no jump: a queue that drops frames
  /// says so.
  void advance(std::int64_t pts, std::int64_t duration, bool discont);
  /// Somebody has looked at this frame: what comes next follows on it.
  void seen() { jumped_ = false; }

  std::int64_t time() const { return time_; }  ///< ns since the first frame
  /// A frame since the last that was seen() did not follow on its predecessor: `discont` with nothing missing (a
  /// cut), or stamps that jumped by more than min_jump, forward or back.
  bool jumped() const { return jumped_; }

 private:
  std::int64_t time_ = 0, last_pts_ = no_time, last_duration_ = no_time;
  bool any_ = false, jumped_ = false;
};

}  // namespace csd
