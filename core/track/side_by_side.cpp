// SPDX-License-Identifier: LGPL-2.1-or-later
#include "track/side_by_side.h"

#include <algorithm>
#include <atomic>
#include <exception>
#include <memory>
#include <mutex>
#include <thread>

namespace csd {
namespace {

constexpr std::size_t grain = 4;  // jobs taken at once: some 50 µs of alignments, against 1 µs to take them

/// One call of each(). A helper that comes late finds nothing left to do and no longer touches `job`.
struct Round {
  const std::function<void(std::size_t)> *job;
  std::size_t n;
  std::atomic<std::size_t> next{0}, done{0};
  std::mutex mutex;
  std::exception_ptr thrown;  // guarded by mutex; the first one

  void work() {
    for (;;) {
      const auto begin = next.fetch_add(grain);
      if (begin >= n) return;
      const auto end = std::min(begin + grain, n);
      for (auto i = begin; i < end; ++i) {
        try {
          (*job)(i);
        } catch (...) {
          const std::lock_guard lock(mutex);
          if (!thrown) thrown = std::current_exception();
        }
      }
      done.fetch_add(end - begin);
    }
  }
};

}  // namespace

void SideBySide::each(std::size_t n, const std::function<void(std::size_t)> &job) const {
  const auto helpers = executor_ && n > grain ? std::min<std::size_t>(executor_->width(), (n - 1) / grain) : 0;
  if (helpers == 0) {
    for (std::size_t i = 0; i < n; ++i) job(i);
    return;
  }
  const auto round = std::make_shared<Round>();
  round->job = &job;
  round->n = n;
  try {
    for (std::size_t i = 0; i < helpers; ++i) executor_->post([round] { round->work(); });
  } catch (const std::exception &) {
    // No memory for a helper: this thread continues alone.
  }
  round->work();
  while (round->done.load() < n) std::this_thread::yield();
  if (round->thrown) std::rethrow_exception(round->thrown);
}

}  // namespace csd
