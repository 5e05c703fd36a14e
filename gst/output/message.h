// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <gst/gst.h>

#include <optional>

#include "settings.h"
#include "track/types.h"

namespace csd {

/// When a frame is, in the four ways that GStreamer's analysers say it. GST_CLOCK_TIME_NONE where unknown.
struct FrameTimes {
  GstClockTime timestamp = GST_CLOCK_TIME_NONE;
  GstClockTime stream_time = GST_CLOCK_TIME_NONE;
  GstClockTime running_time = GST_CLOCK_TIME_NONE;
  GstClockTime duration = GST_CLOCK_TIME_NONE;
};

FrameTimes frame_times(const GstSegment &segment, GstBuffer *buffer);

/// Decides which frames get a message: one policy, whoever posts.
class MessageGate {
 public:
  /// To be asked once a frame, in order. `changed`: a feature is new or its state another. A change that falls into the
  /// interval is not forgotten: it comes due with the interval's end. Frames without a running time are always due, and
  /// so is the first after time went back.
  bool due(GstCsdTrackPostMessages mode, GstClockTime interval, bool changed, GstClockTime running_time);

  /// A change waits for the interval's end.
  bool pending() const { return pending_; }

 private:
  bool pending_ = false;
  GstClockTime last_ = GST_CLOCK_TIME_NONE;
};

/// Posts the element message `csdtrack` of the frames that MessageGate says. `algorithm` is the name that it shows.
class TrackMessages {
 public:
  /// To be told once a frame, in order.
  void frame(GstElement *element, const char *algorithm, const LiveSettings &live, const Tracks &tracks,
             const FrameTimes &times);
  /// The stream has ended: a change that waits is posted now, as the last frame had it.
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
