// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <gst/video/video.h>

#include <cstdint>
#include <optional>

#include "text/read_line.h"

namespace csd {

/// The stream time of `time`, possibly before `segment`, in ns; nothing if unknown or over max_time.
std::optional<std::int64_t> stream_time(const GstSegment &segment, GstClockTime time);

/// The stream time, at most max_time, up to which a GAP event announces no data: its end, or its start if it has no
/// duration. Nothing if unknown.
std::optional<std::int64_t> gap_end(const GstSegment &segment, GstEvent *gap);

struct FrameTime {
  std::optional<std::int64_t> time;  ///< stream time
  std::int64_t reach;                ///< half the frame's duration; 20 ms if unknown
};

/// Updates the controlled properties of a GstObject to the stream time of a buffer in `segment`.
void sync_properties(gpointer object, const GstSegment &segment, GstBuffer *buffer);

/// The time of a raw video frame. After a seek into the middle of a frame, decoders clip its part before the segment;
/// its end and the framerate then give its start.
FrameTime frame_time(const GstSegment &segment, const GstVideoInfo &info, GstBuffer *buffer);

}  // namespace csd
