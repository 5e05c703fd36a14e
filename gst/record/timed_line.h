// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <cstdint>

#include "text/read_line.h"

namespace csd {

/// Which time of a frame a line belongs to.
enum class TimeBase : std::uint8_t {
  running,  ///< lines that came in a buffer with a time, in a TIME segment
  stream    ///< lines of a file, and of byte streams, which have their own `stream_time` only
};

/// A line and its time in ns.
struct TimedLine {
  std::int64_t time = 0;
  TrackLine line;
  TimeBase base = TimeBase::stream;
};

}  // namespace csd
