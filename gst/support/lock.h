// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <gst/gst.h>

// ThreadSanitizer does not see GLib's futex locks. In its builds the wrapper annotates them.
#if defined(__SANITIZE_THREAD__)
#define CSD_TSAN 1
#elif defined(__has_feature)
#if __has_feature(thread_sanitizer)
#define CSD_TSAN 1
#endif
#endif

#ifdef CSD_TSAN
extern "C" {
void __tsan_acquire(void *addr);
void __tsan_release(void *addr);
}
#endif

namespace csd {

/// Holds the object lock of a GstObject for its lifetime. Don't do anything slow meanwhile, post messages, or call out
/// into the pipeline.
class ObjectLock {
 public:
  explicit ObjectLock(gpointer object) : object_(GST_OBJECT_CAST(object)) {
    GST_OBJECT_LOCK(object_);
#ifdef CSD_TSAN
    __tsan_acquire(object_);
#endif
  }
  ~ObjectLock() {
#ifdef CSD_TSAN
    __tsan_release(object_);
#endif
    GST_OBJECT_UNLOCK(object_);
  }
  ObjectLock(const ObjectLock &) = delete;
  ObjectLock &operator=(const ObjectLock &) = delete;

 private:
  GstObject *object_;
};

}  // namespace csd
