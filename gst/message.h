// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <gst/gst.h>

#include "enums.h"

namespace csd {

/// When a frame is, in the four ways that GStreamer's analysers say it. GST_CLOCK_TIME_NONE where unknown.
struct FrameTimes {
  GstClockTime timestamp = GST_CLOCK_TIME_NONE;
  GstClockTime stream_time = GST_CLOCK_TIME_NONE;
  GstClockTime running_time = GST_CLOCK_TIME_NONE;
  GstClockTime duration = GST_CLOCK_TIME_NONE;
};

FrameTimes frame_times(const GstSegment &segment, GstBuffer *buffer);

/// Posts the element message `csdtrack`: `tracks` (taken over) and the four times.
void post_tracks(GstElement *element, GstStructure *tracks, const FrameTimes &times);

/// Decides which frames get a message: one policy, whoever posts.
class MessageGate {
 public:
  /// To be asked once a frame, in order. `changed`: a feature is new or its state another. A change that falls into the
  /// interval is not forgotten: it comes due with the interval's end. Frames without a running time are always due, and
  /// so is the first after time went back.
  bool due(GstCsdTrackPostMessages mode, GstClockTime interval, bool changed, GstClockTime running_time);

 private:
  bool pending_ = false;
  GstClockTime last_ = GST_CLOCK_TIME_NONE;
};

}  // namespace csd
