// SPDX-License-Identifier: LGPL-2.1-or-later
#include "support/patience.h"

namespace csd {

namespace {

struct Call {
  GstElement *element;
  Patience::Over over;
  gpointer data;
  std::uint64_t what;
};

gboolean ring(GstClock *, GstClockTime, GstClockID, gpointer data) {
  auto *const call = static_cast<Call *>(data);
  call->over(call->data, call->what);
  gst_clear_object(&call->element);  // the element may hold the alarm for ever
  return TRUE;
}

void forget(gpointer data) {
  auto *const call = static_cast<Call *>(data);
  gst_clear_object(&call->element);
  delete call;
}

}  // namespace

void Patience::begin(std::uint64_t what, GstClockTime wait) {
  const std::lock_guard lock(mutex_);
  if (!alarm_ || what_ != what || wait_ > wait) begin_locked(what, wait);
}

void Patience::begin_anew(std::uint64_t what) {
  const std::lock_guard lock(mutex_);
  begin_locked(what, 0);
}

void Patience::begin_locked(std::uint64_t what, GstClockTime wait) {
  end_locked();
  GstClock *const clock = gst_system_clock_obtain();
  const GstClockTime now = gst_clock_get_time(clock);
  // A wait for centuries is no wait that ends.
  alarm_ = gst_clock_new_single_shot_id(clock, wait < GST_CLOCK_TIME_NONE / 2 - now ? now + wait : G_MAXINT64);
  what_ = what;
  wait_ = wait;
  gst_object_ref(element_);
  gst_clock_id_wait_async(alarm_, ring, new Call{element_, over_, data_, what}, forget);
  gst_object_unref(clock);
}

void Patience::end() {
  const std::lock_guard lock(mutex_);
  end_locked();
}

void Patience::end_locked() {
  if (!alarm_) return;
  gst_clock_id_unschedule(alarm_);
  gst_clock_id_unref(alarm_);
  alarm_ = nullptr;
}

}  // namespace csd
