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

/// Lines out of the buffers and events that come to a pad, into a TrackQueue. Only the thread that brings them may use
/// it.
class TextLines {
 public:
  TextLines() { gst_segment_init(&segment_, GST_FORMAT_UNDEFINED); }

  /// `text`: the buffer's. False: the queue takes nothing now. Throws LineError for what is no line, or is earlier
  /// than the one before it; in KLV, which comes over networks, such a line is dropped.
  bool take(GstBuffer *buffer, std::string_view text, TrackQueue &queue);
  void handle(GstEvent *event, TrackQueue &queue);
  /// What comes next begins with a new line, of any time. Half a line that waits for its rest is dropped.
  void begin_anew();
  /// Whether it comes backwards.
  bool backwards() const { return segment_.rate < 0; }
  struct Dropped {
    std::uint64_t line;  ///< its number, from 1
    std::string why;
  };
  /// The first line that was dropped, all or half of it, since this was asked before.
  std::optional<Dropped> take_dropped() { return std::exchange(dropped_, std::nullopt); }
  /// Whether so many buffers of KLV have come without one packet of ours that none will be.
  bool only_others() const { return others_ >= 50; }
  /// Of lines that have come.
  std::uint64_t count() const { return count_; }

 private:
  enum class Form {
    bytes,   ///< lines of JSON, cut anywhere
    track,   ///< of text: a buffer is a line, or one of its text_pieces()
    markup,  ///< the same, of Pango
    klv,     ///< packets with such text, cut anywhere
  };

  /// What comes in a buffer.
  struct Part {
    std::string_view text;
    std::optional<std::int64_t> time;  ///< in the stream
    bool outside = false;              ///< before the stream begins: no frame will be there
    bool discont = false;              ///< something is missing before it
    bool untimed = false;              ///< it has no time where others of its stream may
  };

  void set_caps(const GstCaps *caps);
  /// Whether half a line waits for its rest.
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
  /// Of the buffer in which the next packet begins, if that is the first one there.
  std::optional<std::int64_t> packet_time_;
  unsigned others_ = 0;                     ///< buffers of KLV that could hold one of our packets, but don't
  bool ours_ = false;                       ///< a packet has come
  std::int64_t shift_ = 0;                  ///< from the times in KLV's lines to those of their buffers
  std::string begun_;                       ///< pieces of a line whose last one has yet to come
  std::optional<std::int64_t> begun_time_;  ///< of the first of them
  std::optional<Dropped> dropped_;
  JsonText json_;
  std::uint64_t count_ = 0;
  std::optional<std::int64_t> last_;  ///< time of the last
};

}  // namespace csd
