// SPDX-License-Identifier: LGPL-2.1-or-later
#include "text_lines.h"

#include <string>
#include <utility>

namespace csd {

/// `time`: of the buffer that is this line, where that has one.
bool TextLines::take_line(std::string_view text, std::optional<std::int64_t> time, TrackQueue &queue) {
  text = trimmed(text);
  if (text.empty()) return true;
  TimedLine timed{0, read_frame_line(json_, text)};
  timed.time = time.value_or(timed.line.stream_time);
  if (timed.time == no_time) return true;
  if (last_ && timed.time < *last_)
    throw cli::LineError("its stream time " + std::to_string(timed.time) + " comes after " + std::to_string(*last_) +
                         ": lines must be sorted by it");
  last_ = timed.time;
  return queue.push(std::move(timed));
}

bool TextLines::take(std::string_view text, bool timed, std::optional<std::int64_t> time, TrackQueue &queue) {
  if (form_ != Form::bytes) {
    if (timed && !time) return true;  // before the stream begins: no frame will be there
    const bool flowing =
        form_ == Form::markup ? take_line(unescape_markup(text), time, queue) : take_line(text, time, queue);
    ++count_;
    return flowing;
  }
  bool flowing = true;
  splitter_.add(text, [&](std::string_view line, bool whole) {
    flowing = flowing && ((whole && timed && !time) || take_line(line, whole ? time : std::nullopt, queue));
    ++count_;
  });
  return flowing;
}

bool TextLines::begin_anew() {
  last_.reset();
  const bool torn = splitter_.unfinished();
  splitter_.clear();
  return torn;
}

}  // namespace csd
