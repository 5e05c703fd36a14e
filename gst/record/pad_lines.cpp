// SPDX-License-Identifier: LGPL-2.1-or-later
#include "record/pad_lines.h"

#include <algorithm>
#include <string>
#include <utility>

#include "caps/frame_mapping.h"
#include "caps/frame_time.h"
#include "support/guard.h"

namespace csd {

void PadLines::note_torn_once() {
  if (auto lost = reader_.take_lost(); lost && !std::exchange(warned_torn_, true)) notices_.torn = std::move(lost);
}

/// The KLV in a transport stream may be the camera's rather than the tracks.
void PadLines::note_others_once() {
  if (reader_.only_others() && !std::exchange(warned_others_, true)) notices_.only_others = true;
}

void PadLines::post(GstElement *element, const Notices &notices) {
  if (notices.torn)
    GST_ELEMENT_WARNING(element, STREAM, FAILED,
                        ("What came to the pad text broke off in line %" G_GUINT64_FORMAT
                         ": its frame passes without tracks. Look at what brings the text.",
                         notices.torn->line),
                        ("%s", notices.torn->why.c_str()));
  if (notices.only_others)
    GST_ELEMENT_WARNING(element, STREAM, WRONG_TYPE,
                        ("Frames pass without tracks: KLV comes to the pad text, but none of it is csdtrackenc's. Link "
                         "another data stream of the demuxer."),
                        (nullptr));
}

void PadLines::take(GstBuffer *buffer, LineMatcher &matcher) {
  if (refused_) return;
  const MappedBytes mapped(buffer);
  try {
    for (TimedLine &line : reader_.read(buffer, mapped.bytes())) matcher.add(std::move(line));
  } catch (const LineError &error) {
    refused_ = warned_torn_ = true;  // one reason is enough
    throw Refusal(GST_STREAM_ERROR_DECODE,
                  "Line " + std::to_string(reader_.count() + 1) + " of what came to the pad text: " + error.what() +
                      ". Link what csdtrackenc has written; in a recording that is its text track.");
  }
  note_torn_once();
  note_others_once();
}

void PadLines::begin_stream(LineMatcher &matcher) {
  reader_.begin_anew();
  note_torn_once();
  // A source that has ended and goes on, as after a broken connection, says nothing about the frames.
  if (std::exchange(ended_, false))
    matcher.lines_begin_anew(true);
  else
    matcher.lines_begin();
  refused_ = warned_torn_ = warned_others_ = false;
}

void PadLines::begin_segment(GstEvent *event, LineMatcher &matcher) {
  const GstSegment *segment = nullptr;
  gst_event_parse_segment(event, &segment);
  reader_.set_segment(*segment);
  if (segment->format == GST_FORMAT_TIME) matcher.lines_begin();
}

void PadLines::gap(GstEvent *event, LineMatcher &matcher) {
  // Between the pieces of a line a gap says nothing about its frame.
  if (reader_.unfinished()) return;
  GstClockTime begin = 0, duration = GST_CLOCK_TIME_NONE;
  gst_event_parse_gap(event, &begin, &duration);
  const GstSegment &segment = reader_.segment();
  auto from = running_time(segment, begin);
  // Beyond all time. Nothing comes before it.
  if (!from && segment.format == GST_FORMAT_TIME && segment.rate > 0 && begin > segment.start) from = max_time;
  if (!from) return;
  // Without a duration it only says that nothing comes before its beginning.
  std::optional<std::int64_t> until = from;
  if (GST_CLOCK_TIME_IS_VALID(duration)) {
    until = duration < GST_CLOCK_TIME_NONE - begin ? running_time(segment, begin + duration) : std::nullopt;
    if (!until) until = max_time;
  }
  matcher.no_line(std::min(*from, *until), std::max(*from, *until));
}

void PadLines::handle(GstEvent *event, LineMatcher &matcher) {
  switch (GST_EVENT_TYPE(event)) {
    case GST_EVENT_STREAM_START:
      begin_stream(matcher);
      break;
    case GST_EVENT_CAPS: {
      GstCaps *caps = nullptr;
      gst_event_parse_caps(event, &caps);
      reader_.set_caps(caps);
      break;
    }
    case GST_EVENT_SEGMENT:
      begin_segment(event, matcher);
      break;
    case GST_EVENT_GAP:
      gap(event, matcher);
      break;
    case GST_EVENT_EOS:
      reader_.begin_anew();
      note_torn_once();
      ended_ = true;
      break;
    default:
      break;
  }
}

void PadLines::flush(LineMatcher &matcher) {
  reader_.begin_anew();
  reader_.take_lost();  // a seek loses nothing
  GstSegment none;
  gst_segment_init(&none, GST_FORMAT_UNDEFINED);
  reader_.set_segment(none);
  matcher.lines_begin_anew(false);
  ended_ = refused_ = false;
}

void PadLines::relinked(LineMatcher &matcher) {
  reader_.begin_anew();
  note_torn_once();
  matcher.lines_begin_anew(true);
  ended_ = refused_ = warned_torn_ = warned_others_ = false;
}

}  // namespace csd
