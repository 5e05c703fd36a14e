// SPDX-License-Identifier: LGPL-2.1-or-later
#include "record/frame_events.h"

#include "caps/frame_time.h"

namespace csd {

guint group_of(GstEvent *event) {
  guint group = 0;
  gst_event_parse_group_id(event, &group);
  return group;
}

void handle_frame_event(TrackQueue &queue, GstEvent *event, const GstSegment &segment, std::int64_t offset) {
  switch (GST_EVENT_TYPE(event)) {
    case GST_EVENT_STREAM_START:
      queue.frames_begin(group_of(event));
      break;
    case GST_EVENT_FLUSH_START:
      queue.flush_frames(true);
      break;
    case GST_EVENT_FLUSH_STOP:
      queue.flush_frames(false);
      break;
    case GST_EVENT_SEGMENT: {
      const GstSegment *next = nullptr;
      gst_event_parse_segment(event, &next);
      if (next->rate < 0)
        queue.frames_end();  // text only plays forward
      else
        queue.frames_segment();
      break;
    }
    case GST_EVENT_GAP: {
      GstClockTime begin = 0, duration = GST_CLOCK_TIME_NONE;
      gst_event_parse_gap(event, &begin, &duration);
      if (const auto time = stream_time(segment, begin)) queue.skip(*time - offset);
      break;
    }
    case GST_EVENT_EOS:
      queue.frames_end();
      break;
    default:
      break;
  }
}

}  // namespace csd
