// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <gst/gst.h>

#include <chrono>
#include <memory>
#include <optional>

#include "upstream_latency.h"

namespace csd {

/// How long a frame may wait for its line.
struct FrameLimit {
  struct Unref {
    void operator()(GstClock *clock) const { gst_object_unref(clock); }
  };

  std::chrono::nanoseconds patience{0};    ///< from when it asks
  std::unique_ptr<GstClock, Unref> clock;  ///< live: until it shows `time` instead
  GstClockTime time = GST_CLOCK_TIME_NONE;
  bool by_latency = false;  ///< `time` is that of the latency, not of max-wait
};

/// Of the frame at `pts` in `segment`, which has come to `element` now. `latency`: that sinks reckon with, where the
/// element plays; while paused, the clock is no measure.
FrameLimit frame_limit(GstElement *element, const GstSegment &segment, GstClockTime pts,
                       const std::optional<UpstreamLatency::Latency> &latency, GstClockTime max_wait);

}  // namespace csd
