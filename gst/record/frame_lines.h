// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <gst/base/gstaggregator.h>

#include <atomic>
#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <string>

#include "caps/frame_time.h"
#include "record/line_matcher.h"
#include "record/pad_lines.h"
#include "record/track_file.h"
#include "support/guard.h"

namespace csd {

/// The line of each frame of a GstAggregator: from a file, or from its pad `text`. Reports on the element's bus, once
/// per stream, why frames pass without tracks.
///
/// The element's own thread calls it, unless a function says otherwise.
class FrameLines {
 public:
  /// `guard` words the errors.
  FrameLines(GstElement *element, const Guard &guard) : element_(element), guard_(guard) {}

  /// In state changes: forgets everything, and reads from `file`; null: from the pad.
  void start(std::unique_ptr<TrackFile> file);

  // Frames.

  /// A new stream, with its stream-id (null in a new segment of the same).
  void frames_begin(const char *stream_id);
  /// After a flush, between two frames. From any thread.
  void flush_frames();
  /// The next frame, which is then the current one. Call it as often as you like.
  void frame(const FrameMoments &moments);

  /// Why a frame goes on although its line isn't known.
  struct Given {
    bool due = false;           ///< live: the latency is over
    bool overdue = false;       ///< max-wait is over
    GstClockTime max_wait = 0;  ///< for the message
  };
  /// The current frame's line, if any. Returns false if it isn't known yet and the frame can wait. Takes what it needs
  /// from `text`; null: there is no such pad. Throws Refusal for an invalid line in the file. Posts it for one from the
  /// pad, as the video goes on.
  bool find(GstAggregatorPad *text, const Given &given, std::optional<TrackLine> &line);
  /// Whether the current frame has nothing to wait for.
  bool need_not_wait();
  /// A gap in the video: takes what is outdated from `text`.
  void skip(GstAggregatorPad *text, const FrameMoments &moments);

  // The pad text.

  /// What to post then, with no lock held.
  [[nodiscard]] PadLines::Notices text_event(GstEvent *event);
  /// From any thread.
  void flush_text();
  /// By EOS.
  bool text_ended();
  void set_linked(bool linked);
  bool linked() const { return linked_; }
  /// If the link is another one than at the last call: an event for text_event() that says so, in order with what comes
  /// over both. Linking the same pads again brings no STREAM_START. From any thread.
  GstEvent *take_relinked();
  /// Whether to drop what comes to the pad, as there is a file. Reports it once. From any thread.
  bool leave_text();

 private:
  std::optional<TrackLine> find_in_file();
  bool find_on_pad(GstAggregatorPad *text, const Given &given, std::optional<TrackLine> &line);
  void read(GstAggregatorPad *text);
  template <class Change>
  void change_pad(Change change);
  void warn_late_once(const Given &given, GstClockTime latency);
  void warn_back_once();
  void warn_nothing_once();

  GstElement *const element_;
  const Guard &guard_;
  std::unique_ptr<TrackFile> file_;
  std::string first_stream_;     ///< its id: the one that the file is for
  bool another_stream_ = false;  ///< the current one is not the first
  bool late_ = false;            ///< a frame has waited in vain, and no line has come in time since
  bool warned_late_ = false, warned_nothing_ = false, warned_another_ = false, warned_back_ = false;
  FrameMoments now_;

  std::atomic<bool> linked_ = false;
  std::atomic<bool> relinked_ = false;  ///< or unlinked, and linked before
  std::atomic<bool> from_file_ = false, warned_unread_ = false;

  std::mutex mutex_;  ///< of the rest; held only for a short while
  PadLines pad_;
  LineMatcher matcher_;
};

}  // namespace csd
