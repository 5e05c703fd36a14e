// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <gst/gst.h>

#include <mutex>

namespace csd {

/// The serialized events in the queue of a GstAggregator's sink pad, which only the base class sees. Its thread takes
/// an event in hand and handles it later, while a flush may empty the queue: here it learns that the event is void.
/// Thread-safe. Nothing throws.
class QueuedEvents {
 public:
  QueuedEvents() = default;
  ~QueuedEvents() { clear(); }
  QueuedEvents(const QueuedEvents &) = delete;
  QueuedEvents &operator=(const QueuedEvents &) = delete;

  /// Before the base class's sink_event_pre_queue(). Other events than serialized ones don't count.
  void add(GstEvent *event);
  /// If that did not take it.
  void remove(GstEvent *event);
  /// In sink_event(), before `event` takes effect: whether it may. Not if it was flushed.
  bool take(GstEvent *event);
  /// Forgets what a flush drops: all but sticky events, and of these EOS and SEGMENT.
  void flush();
  /// Forgets all.
  void clear();
  /// Whether a STREAM_START or a SEGMENT is in the queue: what comes now belongs to another stream than what is
  /// handled.
  bool begin_anew() const;

 private:
  bool remove_locked(GstEvent *event);

  mutable std::mutex mutex_;
  GQueue events_ = G_QUEUE_INIT;  ///< with references; guarded by mutex_
};

}  // namespace csd
