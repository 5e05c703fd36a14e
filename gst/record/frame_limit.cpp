// SPDX-License-Identifier: LGPL-2.1-or-later
#include "record/frame_limit.h"

#include <algorithm>

#include "caps/frame_time.h"

namespace csd {

namespace {

/// The clock time of `element` at the running time of `time`; nothing if unknown or over max_time.
std::optional<GstClockTime> clock_time(GstElement *element, const GstSegment &segment, GstClockTime time) {
  if (segment.format != GST_FORMAT_TIME || !GST_CLOCK_TIME_IS_VALID(time)) return std::nullopt;
  const GstClockTime running = gst_segment_to_running_time(&segment, GST_FORMAT_TIME, time);
  const GstClockTime base = gst_element_get_base_time(element);
  constexpr auto most = static_cast<GstClockTime>(max_time);
  if (running > most || base > most - running) return std::nullopt;  // includes GST_CLOCK_TIME_NONE
  return base + running;
}

}  // namespace

FrameLimit frame_limit(GstElement *element, const GstSegment &segment, GstClockTime pts,
                       const std::optional<UpstreamLatency::Latency> &latency, GstClockTime max_wait) {
  FrameLimit limit;
  limit.patience = std::chrono::nanoseconds(max_wait);
  if (max_wait == 0 || !latency || !latency->live) return limit;
  limit.clock.reset(gst_element_get_clock(element));
  if (!limit.clock) return limit;
  const GstClockTime now = gst_clock_get_time(limit.clock.get());
  const auto due = clock_time(element, segment, pts);
  const GstClockTime last = due ? *due + std::min<GstClockTime>(latency->min, max_time) : now;
  limit.by_latency = last < now + max_wait;
  limit.time = std::min(last, now + max_wait);
  return limit;
}

}  // namespace csd
