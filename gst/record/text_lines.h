// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <gst/gst.h>

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include "record/klv.h"
#include "record/track_queue.h"

namespace csd {

/// Passes lines from a pad's buffers and events to a TrackQueue. Only the pad's streaming thread may use it.
class TextLines {
 public:
  TextLines() { gst_segment_init(&segment_, GST_FORMAT_UNDEFINED); }

  /// `text`: the buffer's. Returns false if the queue accepts nothing now. Throws LineError for an invalid line, or one
  /// earlier than the line before it; in KLV, which comes over networks, it drops such a line.
  bool take(GstBuffer *buffer, std::string_view text, TrackQueue &queue);
  void handle(GstEvent *event, TrackQueue &queue);
  /// What comes next starts a new line, at any time. Drops a partial line.
  void begin_anew();
  /// Whether the text plays backwards.
  bool backwards() const { return segment_.rate < 0; }
  struct Dropped {
    std::uint64_t line;  ///< its number, from 1
    std::string why;
  };
  /// The first line dropped, in whole or in part, since the last call.
  std::optional<Dropped> take_dropped() { return std::exchange(dropped_, std::nullopt); }
  /// Whether so many KLV buffers without a packet of ours have come that none can be expected.
  bool only_others() const { return others_ >= 50; }
  /// Number of lines received.
  std::uint64_t count() const { return count_; }

 private:
  enum class Form {
    bytes,   ///< JSON lines, split anywhere
    track,   ///< text: a buffer is a line, or one of its text_pieces()
    markup,  ///< the same as Pango markup
    klv,     ///< packets with such text, split anywhere
  };

  /// The contents of a buffer.
  struct Part {
    std::string_view text;
    std::optional<std::int64_t> time;  ///< stream time
    bool outside = false;              ///< before the start of the stream: no frame will match it
    bool discont = false;              ///< data is missing before it
    bool untimed = false;              ///< has no time, although others of its stream may
  };

  void set_caps(const GstCaps *caps);
  /// Whether a partial line is pending.
  bool unfinished() const { return splitter_.unfinished() || packets_.unfinished() || !begun_.empty(); }
  bool take_line(std::string_view text, std::optional<std::int64_t> time, TrackQueue &queue);
  bool take_piece(std::string_view text, const Part &part, TrackQueue &queue);
  bool take_packet(std::string_view text, bool follows, Part part, TrackQueue &queue);
  void lose_line(std::string why);
  void drop_pieces();
  void drop_half();

  GstSegment segment_;
  Form form_ = Form::bytes;
  LineSplitter splitter_;
  KlvSplitter packets_;
  /// Time of the buffer in which the next packet starts, if it is the first one there.
  std::optional<std::int64_t> packet_time_;
  unsigned others_ = 0;                     ///< KLV buffers large enough for one of our packets, but without one
  bool ours_ = false;                       ///< a packet was found
  std::int64_t shift_ = 0;                  ///< from the times in KLV lines to those of their buffers
  std::string begun_;                       ///< pieces of an incomplete line
  std::optional<std::int64_t> begun_time_;  ///< time of the first of them
  std::optional<Dropped> dropped_;
  JsonText json_;
  std::uint64_t count_ = 0;
  std::optional<std::int64_t> last_;  ///< time of the last line
};

}  // namespace csd
