// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <condition_variable>
#include <deque>
#include <mutex>
#include <thread>
#include <vector>

#include "track/executor.h"

namespace csd {

/// A fixed set of threads with one owner; nothing process-wide.
class ThreadPool final : public Executor {
 public:
  /// `threads`: 0 means one per processor less one, at least one. `nice` is added to the threads' nice value where the
  /// system allows it (Linux): learners run below normal priority, so that an encoder takes precedence.
  explicit ThreadPool(unsigned threads = 0, int nice = 0);
  /// Drops the jobs that have not begun and waits for the others.
  ~ThreadPool() override;
  ThreadPool(const ThreadPool &) = delete;
  ThreadPool &operator=(const ThreadPool &) = delete;

  void post(std::function<void()> job) override;
  unsigned width() const override { return static_cast<unsigned>(threads_.size()); }

 private:
  void work(int nice);

  std::mutex mutex_;
  std::condition_variable wake_;
  std::deque<std::function<void()>> jobs_;  // guarded by mutex_
  bool stop_ = false;                       // guarded by mutex_
  std::vector<std::thread> threads_;
};

}  // namespace csd
