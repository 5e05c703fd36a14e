/* SPDX-License-Identifier: LGPL-2.1-or-later
 * Tells ThreadSanitizer about GLib's locks. GLib is not instrumented and has its own futex locks, so TSan would report
 * races on everything that they guard. The tsan set-up loads this before GLib. It does nothing in a program without
 * TSan.
 *
 * A lock acquires what the last unlock of the same address released. Readers release, too. That orders more than a
 * reader lock does: it can hide a race between two readers that write, but never reports a false one. */
#define _GNU_SOURCE
#include <dlfcn.h>
#include <glib.h>

extern void __tsan_acquire(void *address) __attribute__((weak));
extern void __tsan_release(void *address) __attribute__((weak));

static void acquire(void *address) {
  if (__tsan_acquire) __tsan_acquire(address);
}
static void release(void *address) {
  if (__tsan_release) __tsan_release(address);
}

/* Finds the function that this library wraps. A race here is harmless: both threads find the same. */
#define NEXT(name)                                             \
  static __typeof__(&name) next;                               \
  if (!__atomic_load_n((void **)&next, __ATOMIC_ACQUIRE)) {    \
    void *found = dlsym(RTLD_NEXT, #name);                     \
    __atomic_store_n((void **)&next, found, __ATOMIC_RELEASE); \
  }

#define LOCK(name, type)                                         \
  __attribute__((visibility("default"))) void name(type *lock) { \
    NEXT(name)                                                   \
    next(lock);                                                  \
    acquire(lock);                                               \
  }
#define TRYLOCK(name, type)                                          \
  __attribute__((visibility("default"))) gboolean name(type *lock) { \
    NEXT(name)                                                       \
    const gboolean got = next(lock);                                 \
    if (got) acquire(lock);                                          \
    return got;                                                      \
  }
#define UNLOCK(name, type)                                       \
  __attribute__((visibility("default"))) void name(type *lock) { \
    NEXT(name)                                                   \
    release(lock);                                               \
    next(lock);                                                  \
  }

LOCK(g_mutex_lock, GMutex)
TRYLOCK(g_mutex_trylock, GMutex)
UNLOCK(g_mutex_unlock, GMutex)
LOCK(g_rec_mutex_lock, GRecMutex)
TRYLOCK(g_rec_mutex_trylock, GRecMutex)
UNLOCK(g_rec_mutex_unlock, GRecMutex)
LOCK(g_rw_lock_writer_lock, GRWLock)
TRYLOCK(g_rw_lock_writer_trylock, GRWLock)
UNLOCK(g_rw_lock_writer_unlock, GRWLock)
LOCK(g_rw_lock_reader_lock, GRWLock)
TRYLOCK(g_rw_lock_reader_trylock, GRWLock)
UNLOCK(g_rw_lock_reader_unlock, GRWLock)
UNLOCK(g_cond_signal, GCond)
UNLOCK(g_cond_broadcast, GCond)

__attribute__((visibility("default"))) void g_cond_wait(GCond *cond, GMutex *mutex) {
  NEXT(g_cond_wait)
  release(mutex);
  next(cond, mutex);
  acquire(mutex);
  acquire(cond);
}

__attribute__((visibility("default"))) gboolean g_cond_wait_until(GCond *cond, GMutex *mutex, gint64 end) {
  NEXT(g_cond_wait_until)
  release(mutex);
  const gboolean signalled = next(cond, mutex, end);
  acquire(mutex);
  acquire(cond);
  return signalled;
}

/* GLib takes a queue's lock internally, out of reach of this library. After taking an item out, a thread sees what was
 * done before the item was put in. GstHarness passes frames through such queues. */
__attribute__((visibility("default"))) void g_async_queue_push(GAsyncQueue *queue, gpointer item) {
  NEXT(g_async_queue_push)
  release(queue);
  next(queue, item);
}

__attribute__((visibility("default"))) gpointer g_async_queue_pop(GAsyncQueue *queue) {
  NEXT(g_async_queue_pop)
  const gpointer item = next(queue);
  acquire(queue);
  return item;
}

__attribute__((visibility("default"))) gpointer g_async_queue_try_pop(GAsyncQueue *queue) {
  NEXT(g_async_queue_try_pop)
  const gpointer item = next(queue);
  acquire(queue);
  return item;
}

__attribute__((visibility("default"))) gpointer g_async_queue_timeout_pop(GAsyncQueue *queue, guint64 microseconds) {
  NEXT(g_async_queue_timeout_pop)
  const gpointer item = next(queue, microseconds);
  acquire(queue);
  return item;
}

/* One-time initialisation: a thread that sees the value sees the work behind it. The headers also define macros. */
#undef g_once_init_enter
#undef g_once_init_leave
__attribute__((visibility("default"))) gboolean g_once_init_enter(volatile void *location) {
  NEXT(g_once_init_enter)
  const gboolean first = next(location);
  if (!first) acquire((void *)location);
  return first;
}

__attribute__((visibility("default"))) void g_once_init_leave(volatile void *location, gsize result) {
  NEXT(g_once_init_leave)
  release((void *)location);
  next(location, result);
}
