// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <gst/gst.h>

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "record/text_form.h"
#include "record/timed_line.h"

namespace csd {

/// Reads lines from a pad's buffers, in whatever form its caps say. A plain value without locking.
class TextReader {
 public:
  void set_caps(const GstCaps *caps) { form_ = make_text_form(caps); }
  void set_segment(const GstSegment &segment);
  const GstSegment &segment() const { return segment_; }

  /// The lines that a buffer with this text completes. Those of other streams' text, of no time, and empty ones are
  /// skipped, and in reverse those that are earlier than the line before. Throws LineError for an invalid line, and
  /// otherwise for one earlier than the line before it.
  std::vector<TimedLine> read(GstBuffer *buffer, std::string_view text);
  /// What comes next starts a new line, at any time. An unfinished line is lost.
  void begin_anew();

  /// Whether a line has begun.
  bool unfinished() const { return form_ && form_->unfinished(); }
  bool hopeless() const { return form_ && form_->hopeless(); }
  bool only_others() const { return form_ && form_->only_others(); }
  /// Number of lines so far.
  std::uint64_t count() const { return count_; }

  struct Lost {
    std::uint64_t line;  ///< its number, from 1
    std::string why;
  };
  /// The first line lost, in whole or in part, since the last call.
  std::optional<Lost> take_lost() { return std::exchange(lost_, std::nullopt); }

 private:
  std::optional<TimedLine> timed(std::string_view text, const TextTime &time);
  void lose(const char *why);

  GstSegment segment_ = [] {
    GstSegment segment;
    gst_segment_init(&segment, GST_FORMAT_UNDEFINED);
    return segment;
  }();
  std::unique_ptr<TextForm> form_;
  JsonText json_;
  /// From lines' own stream time to the running time of their buffers: in KLV, only the first line of a buffer has it.
  std::optional<std::int64_t> shift_;
  std::optional<std::int64_t> last_;  ///< time of the last line
  TimeBase last_base_ = TimeBase::stream;
  std::uint64_t count_ = 0;
  std::optional<Lost> lost_;
};

}  // namespace csd
