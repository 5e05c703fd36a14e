// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <gst/video/video.h>

#include <cstdint>
#include <optional>

#include "text/read_line.h"

namespace csd {

/// The stream time of `time`, which may lie before `segment`, in ns; nothing where it is not known or over max_time.
std::optional<std::int64_t> stream_time(const GstSegment &segment, GstClockTime time);

/// Until which stream time, at most max_time, a GAP event says that nothing comes: its end, or its begin where it
/// doesn't say how long it is. Nothing where that is not known.
std::optional<std::int64_t> gap_end(const GstSegment &segment, GstEvent *gap);

struct FrameTime {
  std::optional<std::int64_t> time;  ///< of the stream
  std::int64_t reach;                ///< half of how long the frame lasts; 20 ms where nothing says
};

/// When a frame of raw video is. Where a seek leads into the middle of one, decoders cut off what lies before the
/// segment: its end, and the framerate, tell then when it began.
FrameTime frame_time(const GstSegment &segment, const GstVideoInfo &info, GstBuffer *buffer);

}  // namespace csd
