// SPDX-License-Identifier: LGPL-2.1-or-later
#include "meta/message.h"

#include "meta/meta.h"

namespace csd {

FrameTimes frame_times(const GstSegment &segment, GstBuffer *buffer) {
  FrameTimes times;
  times.timestamp = GST_BUFFER_PTS(buffer);
  times.duration = GST_BUFFER_DURATION(buffer);
  if (segment.format != GST_FORMAT_TIME || !GST_CLOCK_TIME_IS_VALID(times.timestamp)) return times;
  times.stream_time = gst_segment_to_stream_time(&segment, GST_FORMAT_TIME, times.timestamp);
  times.running_time = gst_segment_to_running_time(&segment, GST_FORMAT_TIME, times.timestamp);
  return times;
}

bool MessageGate::due(GstCsdTrackPostMessages mode, GstClockTime interval, bool changed, GstClockTime running_time) {
  if (mode == GST_CSD_TRACK_POST_MESSAGES_NONE) {
    pending_ = false;
    return false;
  }
  pending_ |= changed || mode == GST_CSD_TRACK_POST_MESSAGES_FRAME;
  const bool known = GST_CLOCK_TIME_IS_VALID(running_time) && GST_CLOCK_TIME_IS_VALID(last_);
  if (!pending_ || (known && running_time >= last_ && running_time - last_ < interval)) return false;
  pending_ = false;
  last_ = running_time;
  return true;
}

static void post(GstElement *element, const char *algorithm, const Tracks &tracks, const FrameTimes &times) {
  GstStructure *s = new_tracks_structure("csdtrack", tracks, GST_OBJECT_NAME(element), algorithm);
  gst_structure_set(s, "timestamp", GST_TYPE_CLOCK_TIME, times.timestamp, "stream-time", GST_TYPE_CLOCK_TIME,
                    times.stream_time, "running-time", GST_TYPE_CLOCK_TIME, times.running_time, "duration",
                    GST_TYPE_CLOCK_TIME, times.duration, nullptr);
  gst_element_post_message(element, gst_message_new_element(GST_OBJECT_CAST(element), s));
}

void TrackMessages::frame(GstElement *element, const char *algorithm, const LiveSettings &live, const Tracks &tracks,
                          const FrameTimes &times) {
  if (gate_.due(live.post_messages, live.message_interval, tracks.changed, times.running_time))
    post(element, algorithm, tracks, times);
  if (gate_.pending())
    held_ = {tracks, times};
  else
    held_.reset();
}

void TrackMessages::end(GstElement *element, const char *algorithm, const LiveSettings &live) {
  if (held_ && gate_.due(live.post_messages, 0, false, held_->times.running_time))
    post(element, algorithm, held_->tracks, held_->times);
  held_.reset();
}

}  // namespace csd
