// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <gst/gst.h>

#include <optional>

#include "base/types.h"
#include "support/settings.h"

namespace csd {

/// The four times of a frame, as in GStreamer's analysis messages. GST_CLOCK_TIME_NONE where unknown.
struct FrameTimes {
  GstClockTime timestamp = GST_CLOCK_TIME_NONE;
  GstClockTime stream_time = GST_CLOCK_TIME_NONE;
  GstClockTime running_time = GST_CLOCK_TIME_NONE;
  GstClockTime duration = GST_CLOCK_TIME_NONE;
};

FrameTimes frame_times(const GstSegment &segment, GstBuffer *buffer);

/// Decides which frames get a message: one policy for all posters.
class MessageGate {
 public:
  /// Call once per frame, in order. `changed`: a feature is new or has a new state. A change within the interval is
  /// posted when the interval ends. Frames without a running time are always due, and so is the first after time went
  /// back.
  bool due(GstCsdTrackPostMessages mode, GstClockTime interval, bool changed, GstClockTime running_time);

  /// A change waits for the end of the interval.
  bool pending() const { return pending_; }

 private:
  bool pending_ = false;
  GstClockTime last_ = GST_CLOCK_TIME_NONE;
};

/// Posts the element message `csdtrack` for the frames that MessageGate selects. `algorithm` is the name in the
/// message.
class TrackMessages {
 public:
  /// Call once per frame, in order.
  void frame(GstElement *element, const char *algorithm, const LiveSettings &live, const Tracks &tracks,
             const FrameTimes &times);
  /// End of stream: posts a waiting change now, as of the last frame.
  void end(GstElement *element, const char *algorithm, const LiveSettings &live);

 private:
  struct Frame {
    Tracks tracks;
    FrameTimes times;
  };
  MessageGate gate_;
  std::optional<Frame> held_;  ///< the last frame, while a change waits
};

}  // namespace csd
