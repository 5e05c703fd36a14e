// SPDX-License-Identifier: LGPL-2.1-or-later
#include "caps/frame_time.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace csd {

namespace {

using Convert = decltype(&gst_segment_to_running_time_full);

std::optional<std::int64_t> converted(Convert convert, const GstSegment &segment, GstClockTime time) {
  if (segment.format != GST_FORMAT_TIME || !GST_CLOCK_TIME_IS_VALID(time)) return std::nullopt;
  guint64 amount = 0;
  const int sign = convert(&segment, GST_FORMAT_TIME, time, &amount);
  if (sign == 0 || amount > static_cast<guint64>(max_time)) return std::nullopt;
  return sign * static_cast<std::int64_t>(amount);
}

/// The part of a frame that its segment has cut off. Its duration was the usual one, and it began at 0 or later.
GstClockTime clipped_part(const GstSegment &segment, GstBuffer *buffer, GstClockTime usual) {
  const GstClockTime begin = GST_BUFFER_PTS(buffer), duration = GST_BUFFER_DURATION(buffer);
  const bool clipped = segment.format == GST_FORMAT_TIME && GST_CLOCK_TIME_IS_VALID(usual) &&
                       GST_CLOCK_TIME_IS_VALID(begin) && GST_CLOCK_TIME_IS_VALID(duration) && begin == segment.start &&
                       duration < usual && begin + duration >= usual;
  return clipped ? usual - duration : 0;
}

}  // namespace

std::optional<std::int64_t> running_time(const GstSegment &segment, GstClockTime time) {
  return converted(gst_segment_to_running_time_full, segment, time);
}

std::optional<std::int64_t> stream_time(const GstSegment &segment, GstClockTime time) {
  return converted(gst_segment_to_stream_time_full, segment, time);
}

std::int64_t FrameMoment::distance(std::int64_t other) const {
  if (other > time) return other - time + clipped;  // from where the frame really began
  return other < time - clipped ? time - clipped - other : 0;
}

GstClockTime FramePace::next(GstClockTime time) {
  const bool known = GST_CLOCK_TIME_IS_VALID(time) && GST_CLOCK_TIME_IS_VALID(last_);
  const GstClockTime distance = known ? std::max(time, last_) - std::min(time, last_) : GST_CLOCK_TIME_NONE;
  last_ = time;
  return std::min(distance, std::exchange(distance_, distance));
}

FrameMoments frame_moments(const GstSegment &segment, const GstVideoInfo &info, GstBuffer *buffer, GstClockTime pace) {
  constexpr GstClockTime day = 86400 * GST_SECOND;
  const GstClockTime usual = info.fps_n > 0 && info.fps_d > 0
                                 ? gst_util_uint64_scale_int(GST_SECOND, info.fps_d, info.fps_n)
                                 : GST_CLOCK_TIME_NONE;
  const GstClockTime clipped = clipped_part(segment, buffer, usual);
  const auto known = [](GstClockTime duration) { return duration > 0 && duration <= day; };
  GstClockTime duration = clipped == 0 ? GST_BUFFER_DURATION(buffer) : usual;
  if (!known(duration)) duration = usual;
  if (!known(duration))
    duration = GST_CLOCK_TIME_IS_VALID(pace) ? std::min<GstClockTime>(pace, 40 * GST_MSECOND) : 4 * GST_MSECOND;
  const auto moment = [&](std::optional<std::int64_t> time, double rate) -> std::optional<FrameMoment> {
    if (!time) return std::nullopt;
    const auto scaled = [rate](GstClockTime span) { return std::llround(static_cast<double>(span) / rate); };
    return FrameMoment{*time, scaled(clipped), scaled(duration / 2)};
  };
  return {moment(running_time(segment, GST_BUFFER_PTS(buffer)), std::abs(segment.rate)),
          moment(stream_time(segment, GST_BUFFER_PTS(buffer)), 1)};
}

FrameMoments shifted(FrameMoments times, std::int64_t offset) {
  for (auto *moment : {&times.running, &times.stream})
    if (*moment) (*moment)->time -= offset;
  return times;
}

FrameMoments gap_moments(const GstSegment &segment, GstEvent *gap) {
  GstClockTime begin = 0;
  gst_event_parse_gap(gap, &begin, nullptr);
  const auto moment = [](std::optional<std::int64_t> time) -> std::optional<FrameMoment> {
    return time ? std::optional(FrameMoment{*time, 0, 0}) : std::nullopt;
  };
  return {moment(running_time(segment, begin)), moment(stream_time(segment, begin))};
}

void sync_properties(gpointer object, const GstSegment &segment, GstBuffer *buffer) {
  if (segment.format != GST_FORMAT_TIME) return;
  const GstClockTime time = gst_segment_to_stream_time(&segment, GST_FORMAT_TIME, GST_BUFFER_PTS(buffer));
  if (GST_CLOCK_TIME_IS_VALID(time)) gst_object_sync_values(GST_OBJECT(object), time);
}

}  // namespace csd
