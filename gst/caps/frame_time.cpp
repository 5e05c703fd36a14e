// SPDX-License-Identifier: LGPL-2.1-or-later
#include "caps/frame_time.h"

namespace csd {

std::optional<std::int64_t> stream_time(const GstSegment &segment, GstClockTime time) {
  if (segment.format != GST_FORMAT_TIME || !GST_CLOCK_TIME_IS_VALID(time)) return std::nullopt;
  guint64 at = 0;
  if (gst_segment_to_stream_time_full(&segment, GST_FORMAT_TIME, time, &at) <= 0) return std::nullopt;
  if (at > static_cast<guint64>(max_time)) return std::nullopt;
  return static_cast<std::int64_t>(at);
}

std::optional<std::int64_t> gap_end(const GstSegment &segment, GstEvent *gap) {
  GstClockTime begin = 0, duration = GST_CLOCK_TIME_NONE;
  gst_event_parse_gap(gap, &begin, &duration);
  const auto from = stream_time(segment, begin);
  if (segment.format != GST_FORMAT_TIME || !GST_CLOCK_TIME_IS_VALID(duration)) return from;
  constexpr auto most = static_cast<GstClockTime>(max_time);
  if (begin > most || duration > most - begin) return max_time;
  const auto to = stream_time(segment, begin + duration);
  return to || !from ? to : max_time;
}

void sync_properties(gpointer object, const GstSegment &segment, GstBuffer *buffer) {
  if (segment.format != GST_FORMAT_TIME) return;
  const GstClockTime time = gst_segment_to_stream_time(&segment, GST_FORMAT_TIME, GST_BUFFER_PTS(buffer));
  if (GST_CLOCK_TIME_IS_VALID(time)) gst_object_sync_values(GST_OBJECT(object), time);
}

FrameTime frame_time(const GstSegment &segment, const GstVideoInfo &info, GstBuffer *buffer) {
  constexpr GstClockTime day = 86400 * GST_SECOND;
  const GstClockTime usual = info.fps_n > 0 && info.fps_d > 0
                                 ? gst_util_uint64_scale_int(GST_SECOND, info.fps_d, info.fps_n)
                                 : GST_CLOCK_TIME_NONE;
  GstClockTime begin = GST_BUFFER_PTS(buffer);
  GstClockTime duration = GST_BUFFER_DURATION_IS_VALID(buffer) ? GST_BUFFER_DURATION(buffer) : usual;
  const bool cut = GST_CLOCK_TIME_IS_VALID(usual) && GST_CLOCK_TIME_IS_VALID(begin) && begin == segment.start &&
                   duration < usual && begin + duration >= usual;
  if (cut) {
    begin = begin + duration - usual;
    duration = usual;
  }
  if (duration == 0 || duration > day) duration = 40 * GST_MSECOND;
  return {stream_time(segment, begin), static_cast<std::int64_t>(duration / 2)};
}

}  // namespace csd
