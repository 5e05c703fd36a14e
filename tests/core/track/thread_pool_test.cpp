// SPDX-License-Identifier: LGPL-2.1-or-later
#include "track/thread_pool.h"

#include <gtest/gtest.h>

#ifdef __linux__
#include <sys/resource.h>
#include <unistd.h>
#endif

#include <atomic>
#include <future>

namespace csd {
namespace {

TEST(ThreadPool, RunsEveryJobOnce) {
  std::atomic<int> sum = 0;
  std::promise<void> last;
  ThreadPool pool(3);
  EXPECT_EQ(pool.width(), 3u);
  std::atomic<int> left = 100;
  for (int i = 1; i <= 100; ++i)
    pool.post([&, i] {
      sum += i;
      if (--left == 0) last.set_value();
    });
  last.get_future().wait();
  EXPECT_EQ(sum, 5050);
}

TEST(ThreadPool, HasAtLeastOneThread) {
  const ThreadPool pool;
  EXPECT_GE(pool.width(), 1u);
}

TEST(ThreadPool, DestructionDropsJobsThatHaveNotBegun) {
  std::atomic<int> ran = 0;
  std::promise<void> begun, go_on;
  {
    ThreadPool pool(1);
    pool.post([&] {
      begun.set_value();
      go_on.get_future().wait();
      ++ran;
    });
    begun.get_future().wait();
    for (int i = 0; i < 10; ++i) pool.post([&] { ++ran; });
    // The destructor empties the queue before it waits. The running job is released only after that can have begun.
    std::thread([&] {
      std::this_thread::sleep_for(std::chrono::milliseconds(50));
      go_on.set_value();
    }).detach();
  }
  EXPECT_EQ(ran, 1);
}

#ifdef __linux__
TEST(ThreadPool, RunsBelowNormalPriority) {
  const int own = getpriority(PRIO_PROCESS, 0);
  std::promise<int> nice;
  ThreadPool pool(1, 7);
  pool.post([&] { nice.set_value(getpriority(PRIO_PROCESS, static_cast<id_t>(gettid()))); });
  EXPECT_EQ(nice.get_future().get(), std::min(own + 7, 19));
  EXPECT_EQ(getpriority(PRIO_PROCESS, 0), own);
}
#endif

}  // namespace
}  // namespace csd
