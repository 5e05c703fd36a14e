// SPDX-License-Identifier: LGPL-2.1-or-later
#include "record/text_reader.h"

#include "caps/frame_time.h"

namespace csd {

void TextReader::set_segment(const GstSegment &segment) {
  gst_segment_copy_into(&segment, &segment_);
  if (segment.format != GST_FORMAT_TIME) return;
  last_.reset();
  shift_.reset();
}

std::optional<TimedLine> TextReader::timed(std::string_view text, const TextTime &time) {
  text = line_text(text);
  if (text.empty()) return std::nullopt;
  TimedLine line{0, read_track_line(json_, text)};
  const std::int64_t own = line.line.stream_time;
  if (time.running && own != no_time) shift_ = *time.running - own;
  if (time.running) {
    line.time = *time.running;
    line.base = TimeBase::running;
  } else if (own == no_time) {
    return std::nullopt;
  } else if (segment_.format == GST_FORMAT_TIME && shift_) {
    line.time = own + *shift_;
    line.base = TimeBase::running;
  } else {
    line.time = own;
  }
  if (last_ && last_base_ == line.base && line.time < *last_) {
    if (segment_.rate < 0) return std::nullopt;  // demuxers turn the order of their parts, not of the lines in them
    throw LineError(std::string("its ") + (line.base == TimeBase::running ? "running" : "stream") + " time " +
                    std::to_string(line.time) + " comes after " + std::to_string(*last_) +
                    ": lines must be sorted by it");
  }
  last_ = line.time;
  last_base_ = line.base;
  return line;
}

std::vector<TimedLine> TextReader::read(GstBuffer *buffer, std::string_view text) {
  std::vector<TimedLine> lines;
  if (!form_) return lines;
  const bool has_times = segment_.format == GST_FORMAT_TIME;
  const TextTime time{running_time(segment_, GST_BUFFER_PTS(buffer)), has_times && !GST_BUFFER_PTS_IS_VALID(buffer)};
  form_->read(
      {text, time, GST_BUFFER_IS_DISCONT(buffer) != 0},
      [&](std::string_view line, const TextTime &its) {
        if (auto read = timed(line, its)) lines.push_back(std::move(*read));
        ++count_;
      },
      [&](const char *why) { lose(why); });
  return lines;
}

void TextReader::begin_anew() {
  last_.reset();
  shift_.reset();
  if (!form_) return;
  if (form_->unfinished()) lose("its rest is missing");
  form_->clear();
}

void TextReader::lose(const char *why) {
  ++count_;
  if (!lost_) lost_ = {count_, why};
}

}  // namespace csd
