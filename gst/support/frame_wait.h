// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <gst/gst.h>

#include <atomic>
#include <cstdint>

#include "support/patience.h"

namespace csd {

/// The frame that a GstAggregator handles next waits for what comes to another pad: not for ever. Thread-safe.
class FrameWait {
 public:
  /// `wake` makes the element's thread look whether the frame can go on.
  FrameWait(GstElement *element, void (*wake)(GstElement *element))
      : element_(element), wake_(wake), patience_(element, on_over, this), look_again_(element, on_look_again, this) {}

  /// The frame waits for at most `wait` ns. Changes nothing if it has already begun to wait as long, or less.
  void begin(GstClockTime wait) { patience_.begin(frame_, wait); }
  /// It begins to wait anew with the next begin().
  void begin_anew() { patience_.end(); }
  /// Wakes the element's thread from another one.
  void look_again() { look_again_.begin_anew(frame_); }
  /// Whether the frame has waited for as long as it may.
  bool over() const { return over_ == frame_; }
  /// The next frame.
  void next();
  /// Ends all waits. A wake may still be under way.
  void stop();

 private:
  static void on_over(gpointer self, std::uint64_t frame);
  static void on_look_again(gpointer self, std::uint64_t frame);

  GstElement *const element_;
  void (*const wake_)(GstElement *element);
  std::atomic<std::uint64_t> frame_ = 1, over_ = 0;  ///< numbers of frames
  Patience patience_, look_again_;
};

}  // namespace csd
