// SPDX-License-Identifier: LGPL-2.1-or-later
#include "track/thread_pool.h"

#include <algorithm>

#ifdef __linux__
#include <pthread.h>
#include <sys/resource.h>
#include <unistd.h>
#endif

namespace csd {

namespace {

void begin_thread(int nice) {
#ifdef __linux__
  pthread_setname_np(pthread_self(), "csd-worker");
  // On Linux a nice value belongs to a thread, addressed by its id. Raising it is always allowed.
  const auto self = static_cast<id_t>(gettid());
  if (nice != 0) setpriority(PRIO_PROCESS, self, getpriority(PRIO_PROCESS, self) + nice);
#else
  (void)nice;
#endif
}

}  // namespace

ThreadPool::ThreadPool(unsigned threads, int nice) {
  if (threads == 0) threads = std::max(2u, std::thread::hardware_concurrency()) - 1;
  threads_.reserve(threads);
  for (unsigned i = 0; i < threads; ++i) {
    // If the system has no thread or memory for a further one, the pool keeps those it has: learning is slower, but
    // nothing fails. It must not throw, because running threads must be joined.
    try {
      threads_.emplace_back([this, nice] { work(nice); });
    } catch (...) {
      if (threads_.empty()) throw;
      break;
    }
  }
}

ThreadPool::~ThreadPool() {
  {
    const std::lock_guard lock(mutex_);
    stop_ = true;
  }
  wake_.notify_all();
  for (auto &thread : threads_) thread.join();
}

void ThreadPool::post(std::function<void()> job) {
  {
    const std::lock_guard lock(mutex_);
    jobs_.push_back(std::move(job));
  }
  wake_.notify_one();
}

void ThreadPool::work(int nice) {
  begin_thread(nice);
  std::unique_lock lock(mutex_);
  for (;;) {
    wake_.wait(lock, [this] { return stop_ || !jobs_.empty(); });
    if (stop_) return;
    auto job = std::move(jobs_.front());
    jobs_.pop_front();
    lock.unlock();
    job();
    job = nullptr;  // frees the job's data outside the lock
    lock.lock();
  }
}

}  // namespace csd
