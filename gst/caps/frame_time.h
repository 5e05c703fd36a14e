// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <gst/video/video.h>

#include <cstdint>
#include <optional>

#include "text/read_line.h"

namespace csd {

/// The running or stream time of `time` in ns; negative before the segment's start. Nothing if unknown, or if its
/// amount is over max_time.
std::optional<std::int64_t> running_time(const GstSegment &segment, GstClockTime time);
std::optional<std::int64_t> stream_time(const GstSegment &segment, GstClockTime time);

/// When a frame is, in ns of running time or of stream time.
struct FrameMoment {
  std::int64_t time;         ///< negative before the segment's start
  std::int64_t clipped = 0;  ///< how much of the frame, before `time`, its segment has cut off
  std::int64_t reach;        ///< half the frame's duration: a line further away belongs to another frame

  /// How far away `other` is from where the frame began; 0 from there to `time`, as its line may be cut off, too.
  std::int64_t distance(std::int64_t other) const;
};

/// The times of a raw video frame; nothing where unknown.
struct FrameMoments {
  std::optional<FrameMoment> running, stream;
};

/// How far apart frames are, for those of no known duration.
class FramePace {
 public:
  /// The next frame's distance to the frame before, or that one's to its own, whichever is less: a dropped frame is no
  /// slower pace. GST_CLOCK_TIME_NONE for the first.
  GstClockTime next(GstClockTime time);

 private:
  GstClockTime last_ = GST_CLOCK_TIME_NONE, distance_ = GST_CLOCK_TIME_NONE;
};

/// A frame lasts as it says, else as the framerate does, else for `pace`, but for 40 ms at most, and without a pace for
/// 4 ms: lines' times may be rounded to milliseconds.
///
/// After a seek into the middle of a frame, or at the start of an edit list, decoders clip the frame's part before the
/// segment. Its end and the framerate then tell its start.
FrameMoments frame_moments(const GstSegment &segment, const GstVideoInfo &info, GstBuffer *buffer,
                           GstClockTime pace = GST_CLOCK_TIME_NONE);

/// The times less `offset` ns.
FrameMoments shifted(FrameMoments times, std::int64_t offset);

/// The times at which a GAP event begins.
FrameMoments gap_moments(const GstSegment &segment, GstEvent *gap);

/// Updates the controlled properties of a GstObject to the stream time of a buffer in `segment`.
void sync_properties(gpointer object, const GstSegment &segment, GstBuffer *buffer);

}  // namespace csd
