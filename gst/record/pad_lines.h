// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <gst/gst.h>

#include <optional>
#include <utility>

#include "record/line_matcher.h"
#include "record/text_reader.h"

namespace csd {

/// The lines that a pad brings, from its buffers and events to a LineMatcher. Not thread-safe.
class PadLines {
 public:
  /// A buffer. Throws Refusal for an invalid line; then what comes is ignored until a new stream begins.
  void take(GstBuffer *buffer, LineMatcher &matcher);
  /// A serialized event.
  void handle(GstEvent *event, LineMatcher &matcher);
  void flush(LineMatcher &matcher);
  /// What comes next comes over another link.
  void relinked(LineMatcher &matcher);

  /// What the user must know.
  struct Notices {
    std::optional<TextReader::Lost> torn;
    bool only_others = false;
  };
  /// Those since the last call.
  Notices take_notices() { return std::exchange(notices_, {}); }
  /// On the bus of `element`. Its handler may call anything, so hold no lock.
  static void post(GstElement *element, const Notices &notices);

  bool ended() const { return ended_; }
  /// Whether no frame need wait: no line can come.
  bool over() const { return ended() || refused_ || reader_.hopeless(); }

 private:
  void begin_stream(LineMatcher &matcher);
  void begin_segment(GstEvent *event, LineMatcher &matcher);
  void gap(GstEvent *event, LineMatcher &matcher);
  void note_torn_once();
  void note_others_once();

  TextReader reader_;
  Notices notices_;
  bool ended_ = false;    ///< by EOS
  bool refused_ = false;  ///< a line
  // Once per stream.
  bool warned_torn_ = false, warned_others_ = false;
};

}  // namespace csd
