// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <cstdint>

#include "base/types.h"

namespace csd {

/// The time of a stream's frames: by their stamps if these are plausible, else by durations. A gap in the stamps never
/// stops it, and it never decreases.
class StreamClock {
 public:
  static constexpr std::int64_t nominal_duration = second / 25;  ///< of a frame, if the stream does not say
  static constexpr std::int64_t min_jump = second / 2;           ///< of the stamps, from their expected value

  /// Advances to the next frame. `pts`, `duration` in ns, no_time if unknown. `discont`: it does not follow the last
  /// frame. If the stamps show a gap of less than min_jump, `discont` is no jump: a queue that drops frames sets it.
  void advance(std::int64_t pts, std::int64_t duration, bool discont);
  /// This frame has been processed: the next one continues from it.
  void seen() { jumped_ = false; }

  std::int64_t time() const { return time_; }  ///< ns since the first frame
  /// Whether the stream jumped since the last frame that was seen(): a `discont` without missing frames (a cut), or
  /// stamps off by more than min_jump, forward or back.
  bool jumped() const { return jumped_; }

 private:
  std::int64_t time_ = 0, last_pts_ = no_time, last_duration_ = no_time;
  bool any_ = false, jumped_ = false;
};

}  // namespace csd
