// SPDX-License-Identifier: LGPL-2.1-or-later
// Two threads increment one variable. Without an argument nothing guards it, and the tsan set-up must fail. With one a
// GMutex does, and the set-up must pass, which it can only if it knows GLib's locks.
#include <glib.h>

#include <thread>

int main(int argc, char **) {
  const bool guarded = argc > 1;
  GMutex mutex;
  g_mutex_init(&mutex);
  long count = 0;
  const auto work = [&] {
    for (int i = 0; i < 1000; ++i) {
      if (guarded) g_mutex_lock(&mutex);
      ++count;
      if (guarded) g_mutex_unlock(&mutex);
    }
  };
  std::thread other(work);
  work();
  other.join();
  g_mutex_clear(&mutex);
  return count > 0 ? 0 : 1;
}
