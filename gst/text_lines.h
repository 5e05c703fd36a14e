// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <gst/gst.h>

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include "track_queue.h"

namespace csd {

/// Lines out of the buffers and events that come to a pad, into a TrackQueue. Only the thread that brings them may use
/// it.
class TextLines {
 public:
  TextLines() { gst_segment_init(&segment_, GST_FORMAT_UNDEFINED); }

  /// `text`: the buffer's. False: the queue takes nothing now. Throws LineError for what is no line, or is earlier
  /// than the one before it.
  bool take(GstBuffer *buffer, std::string_view text, TrackQueue &queue);
  void heed(GstEvent *event, TrackQueue &queue);
  /// What comes next begins with a new line, of any time. Half a line that waits for its rest is dropped.
  void begin_anew();
  /// Whether it comes backwards.
  bool backwards() const { return segment_.rate < 0; }
  /// The number, from 1, of a line half of which was dropped since this was asked last.
  std::optional<std::uint64_t> take_torn() { return std::exchange(torn_, std::nullopt); }
  /// Of lines that have come.
  std::uint64_t count() const { return count_; }

 private:
  enum class Form {
    bytes,   ///< lines of JSON, cut anywhere
    track,   ///< of text: a buffer is a line, or one of its text_pieces()
    markup,  ///< the same, of Pango
  };

  /// What comes in a buffer.
  struct Part {
    std::string_view text;
    std::optional<std::int64_t> time;  ///< in the stream
    bool outside = false;              ///< before the stream begins: no frame will be there
    bool discont = false;              ///< something is missing before it
  };

  void set_caps(const GstCaps *caps);
  /// Whether half a line waits for its rest.
  bool unfinished() const { return splitter_.unfinished() || !begun_.empty(); }
  bool take_line(std::string_view text, std::optional<std::int64_t> time, TrackQueue &queue);
  bool take_piece(std::string_view text, const Part &part, TrackQueue &queue);
  void drop_half();

  GstSegment segment_;
  Form form_ = Form::bytes;
  LineSplitter splitter_;
  std::string begun_;                       ///< pieces of a line whose last one has yet to come
  std::optional<std::int64_t> begun_time_;  ///< of the first of them
  std::optional<std::uint64_t> torn_;
  JsonText json_;
  std::uint64_t count_ = 0;
  std::optional<std::int64_t> last_;  ///< time of the last
};

}  // namespace csd
