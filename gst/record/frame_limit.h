// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <gst/gst.h>

#include <chrono>
#include <memory>
#include <optional>

#include "record/upstream_latency.h"

namespace csd {

/// How long a frame may wait for its line.
struct FrameLimit {
  struct Unref {
    void operator()(GstClock *clock) const { gst_object_unref(clock); }
  };

  std::chrono::nanoseconds patience{0};    ///< without a clock: from the start of the wait
  std::unique_ptr<GstClock, Unref> clock;  ///< live: wait until it reaches `time`
  GstClockTime time = GST_CLOCK_TIME_NONE;
  bool by_latency = false;  ///< `time` comes from the latency, not from max-wait
};

/// The limit for the frame at `pts` in `segment`, which has just reached `element`. `latency`: the one sinks use, if
/// the element is playing; while paused, the clock doesn't apply.
FrameLimit frame_limit(GstElement *element, const GstSegment &segment, GstClockTime pts,
                       const std::optional<UpstreamLatency::Latency> &latency, GstClockTime max_wait);

}  // namespace csd
