// SPDX-License-Identifier: LGPL-2.1-or-later
#include "record/text_lines.h"

#include "caps/frame_time.h"
#include "record/frame_events.h"
#include "record/text_pieces.h"

namespace csd {

/// `time`: of the buffer that holds this line or its start, if that has one.
bool TextLines::take_line(std::string_view text, std::optional<std::int64_t> time, TrackQueue &queue) {
  text = line_text(text);
  if (text.empty()) return true;
  TimedLine timed{0, read_track_line(json_, text)};
  const std::int64_t own = timed.line.stream_time;
  if (form_ == Form::klv && time && own != no_time) shift_ = *time - own;
  timed.time = time ? *time : own == no_time ? no_time : own + shift_;
  if (timed.time == no_time) return true;
  if (last_ && timed.time < *last_)
    throw LineError("its stream time " + std::to_string(timed.time) + " comes after " + std::to_string(*last_) +
                    ": lines must be sorted by it");
  last_ = timed.time;
  return queue.push(std::move(timed));
}

bool TextLines::take_piece(std::string_view text, const Part &part, TrackQueue &queue) {
  text = line_text(text);
  if (text.empty()) return true;
  const bool rest = is_rest_of_line(text);
  if (!rest || part.discont) drop_pieces();
  if (rest && begun_.empty()) return true;  // its start was before a seek, or is lost
  if (!rest && part.outside) {
    ++count_;
    return true;
  }
  if (!rest) begun_time_ = part.time;
  if (begun_.size() + text.size() > max_line_bytes) throw LineError("is longer than 8 MiB");
  begun_ += text;
  if (goes_on(text)) return true;
  const std::string line = std::exchange(begun_, {});
  const bool flowing = take_line(line, begun_time_, queue);
  ++count_;
  return flowing;
}

bool TextLines::take_packet(std::string_view text, bool follows, Part part, TrackQueue &queue) {
  ours_ = true;
  part.discont = !follows;
  part.time = std::exchange(packet_time_, std::nullopt);
  // ffmpeg -c copy leaves such packets (seen with 5.1). Their time is not that of the transport stream, and frames
  // would wait for nothing.
  if (part.untimed) {
    lose_line("it has no timestamp");
    queue.end();
    return true;
  }
  try {
    return take_piece(text, part, queue);
  } catch (const LineError &error) {
    lose_line(error.what());
    return true;
  }
}

void TextLines::set_caps(const GstCaps *caps) {
  const GstStructure *structure = gst_caps_get_structure(caps, 0);
  if (gst_structure_has_name(structure, "application/x-ndjson"))
    form_ = Form::bytes;
  else if (gst_structure_has_name(structure, "meta/x-klv"))
    form_ = Form::klv;
  else if (g_strcmp0(gst_structure_get_string(structure, "format"), "pango-markup") == 0)
    form_ = Form::markup;
  else
    form_ = Form::track;
}

bool TextLines::take(GstBuffer *buffer, std::string_view text, TrackQueue &queue) {
  const bool has_times = segment_.format == GST_FORMAT_TIME, timed = has_times && GST_BUFFER_PTS_IS_VALID(buffer);
  const auto time = stream_time(segment_, GST_BUFFER_PTS(buffer));
  const Part part{text, time, timed && !time, GST_BUFFER_IS_DISCONT(buffer) != 0, has_times && !timed};
  if (form_ == Form::markup) return take_piece(unescape_markup(part.text), part, queue);
  if (form_ == Form::track) return take_piece(part.text, part, queue);
  bool flowing = true;
  if (form_ == Form::klv) {
    if (part.discont) drop_half();
    bool begun_before = packets_.unfinished();
    const auto next = [&] {
      if (std::exchange(begun_before, false)) packet_time_ = part.time;
    };
    if (!begun_before) packet_time_ = part.time;
    packets_.add(
        part.text,
        [&](std::string_view text, bool follows) {
          flowing = flowing && take_packet(text, follows, part, queue);
          next();
        },
        [&] {
          lose_line("a packet was torn");
          next();
        });
    if (!ours_ && !packets_.unfinished() && part.text.size() >= klv_label.size()) ++others_;
    return flowing;
  }
  splitter_.add(part.text, [&](std::string_view line, bool whole) {
    flowing = flowing && ((whole && part.outside) || take_line(line, whole ? part.time : std::nullopt, queue));
    ++count_;
  });
  return flowing;
}

void TextLines::handle(GstEvent *event, TrackQueue &queue) {
  switch (GST_EVENT_TYPE(event)) {
    case GST_EVENT_STREAM_START:
      begin_anew();
      queue.lines_begin(group_of(event));
      break;
    case GST_EVENT_CAPS: {
      GstCaps *caps = nullptr;
      gst_event_parse_caps(event, &caps);
      set_caps(caps);
      break;
    }
    case GST_EVENT_SEGMENT:
      gst_event_copy_segment(event, &segment_);
      queue.segment();
      if (segment_.format == GST_FORMAT_TIME) last_.reset();
      break;
    case GST_EVENT_GAP:
      // Between the pieces of a line a gap says nothing about its frame.
      if (const auto end = gap_end(segment_, event); end && !unfinished()) queue.gap(*end);
      break;
    case GST_EVENT_FLUSH_START:
      queue.flush_lines(true);
      break;
    case GST_EVENT_FLUSH_STOP:
      queue.flush_lines(false);
      gst_segment_init(&segment_, GST_FORMAT_UNDEFINED);
      begin_anew();
      take_dropped();  // lines dropped by a seek are no loss
      break;
    case GST_EVENT_EOS:
      begin_anew();
      queue.end();
      break;
    default:
      break;
  }
}

void TextLines::begin_anew() {
  last_.reset();
  shift_ = 0;
  others_ = 0;
  ours_ = false;
  drop_half();
}

void TextLines::lose_line(std::string why) {
  ++count_;
  if (!dropped_) dropped_ = {count_, std::move(why)};
  begun_.clear();
}

void TextLines::drop_pieces() {
  if (!begun_.empty()) lose_line("its rest is missing");
}

void TextLines::drop_half() {
  if (unfinished()) lose_line("its rest is missing");
  splitter_.clear();
  packets_.clear();
}

}  // namespace csd
