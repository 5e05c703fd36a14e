// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <gst/gst.h>

#include <cstdint>
#include <mutex>

namespace csd {

/// Tells an element when it has waited long enough for something. Thread-safe.
class Patience {
 public:
  /// Called by the system clock's thread, with a reference to the element. Other elements wait for that thread, so this
  /// must take no lock that is held for longer than a moment.
  using Over = void (*)(gpointer data, std::uint64_t what);

  Patience(GstElement *element, Over over, gpointer data) : element_(element), over_(over), data_(data) {}
  ~Patience() { end(); }
  Patience(const Patience &) = delete;
  Patience &operator=(const Patience &) = delete;

  /// Calls `over` for `what` after `wait` ns. Waits for one thing at a time: changes nothing if it has already begun to
  /// wait as long, or less, for the same.
  void begin(std::uint64_t what, GstClockTime wait);
  /// Calls `over` for `what` at once, also if it has done so before.
  void begin_anew(std::uint64_t what);
  /// Ends the wait. A call may still be under way.
  void end();

 private:
  void begin_locked(std::uint64_t what, GstClockTime wait);
  void end_locked();

  GstElement *const element_;
  const Over over_;
  const gpointer data_;
  std::mutex mutex_;
  // Guarded by mutex_.
  GstClockID alarm_ = nullptr;
  std::uint64_t what_ = 0;
  GstClockTime wait_ = 0;
};

}  // namespace csd
