// SPDX-License-Identifier: LGPL-2.1-or-later
#include "support/queued_events.h"

namespace csd {

namespace {

bool is(GstEvent *event, GstEventTypeFlags flag) {
  return (gst_event_type_get_flags(GST_EVENT_TYPE(event)) & flag) != 0;
}

bool flushable(GstEvent *event) {
  return GST_EVENT_TYPE(event) == GST_EVENT_EOS || GST_EVENT_TYPE(event) == GST_EVENT_SEGMENT ||
         !is(event, GST_EVENT_TYPE_STICKY);
}

}  // namespace

void QueuedEvents::add(GstEvent *event) {
  if (!is(event, GST_EVENT_TYPE_SERIALIZED)) return;
  const std::lock_guard lock(mutex_);
  g_queue_push_tail(&events_, gst_event_ref(event));
}

bool QueuedEvents::remove_locked(GstEvent *event) {
  if (!g_queue_remove(&events_, event)) return false;
  gst_event_unref(event);
  return true;
}

void QueuedEvents::remove(GstEvent *event) {
  const std::lock_guard lock(mutex_);
  remove_locked(event);
}

bool QueuedEvents::take(GstEvent *event) {
  const std::lock_guard lock(mutex_);
  return remove_locked(event) || !flushable(event);
}

void QueuedEvents::flush() {
  const std::lock_guard lock(mutex_);
  for (GList *link = events_.head, *next = nullptr; link; link = next) {
    next = link->next;
    auto *event = static_cast<GstEvent *>(link->data);
    if (flushable(event)) remove_locked(event);
  }
}

void QueuedEvents::clear() {
  const std::lock_guard lock(mutex_);
  while (auto *event = static_cast<GstEvent *>(g_queue_pop_head(&events_))) gst_event_unref(event);
}

bool QueuedEvents::begin_anew() const {
  const std::lock_guard lock(mutex_);
  for (const GList *link = events_.head; link; link = link->next) {
    auto *event = static_cast<GstEvent *>(link->data);
    if (GST_EVENT_TYPE(event) == GST_EVENT_STREAM_START || GST_EVENT_TYPE(event) == GST_EVENT_SEGMENT) return true;
  }
  return false;
}

}  // namespace csd
