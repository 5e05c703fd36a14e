// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <cstdint>
#include <optional>
#include <string_view>

#include "track_queue.h"

namespace csd {

/// Lines out of the buffers that come to a pad, into a TrackQueue. Only the thread that brings them may use it.
class TextLines {
 public:
  enum class Form {
    bytes,   ///< lines of JSON, cut anywhere
    line,    ///< a line a buffer
    markup,  ///< the same, of Pango
  };

  void set_form(Form form) { form_ = form; }
  /// What a buffer holds. `timed`: it has a timestamp; `time`: that is this in the stream, none outside of it. False:
  /// the queue takes nothing now. Throws cli::LineError for what is no line, or is earlier than the one before it.
  bool take(std::string_view text, bool timed, std::optional<std::int64_t> time, TrackQueue &queue);
  /// What comes next may be earlier than what came.
  void expect_any_time() { last_.reset(); }
  /// What comes next begins with a new line, of any time. True: half a line was waiting for its rest, and is dropped.
  bool begin_anew();
  /// Of lines that have come.
  std::uint64_t count() const { return count_; }

 private:
  bool take_line(std::string_view text, std::optional<std::int64_t> time, TrackQueue &queue);

  Form form_ = Form::bytes;
  LineSplitter splitter_;
  cli::JsonText json_;
  std::uint64_t count_ = 0;
  std::optional<std::int64_t> last_;  ///< time of the last
};

}  // namespace csd
