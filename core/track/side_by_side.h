// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <cstddef>
#include <functional>

#include "track/executor.h"

namespace csd {

/// Runs the work of one frame on several threads: the caller's and idle ones of an executor. The caller never waits for
/// a helper that has not begun, so if all are busy it does everything itself.
class SideBySide {
 public:
  SideBySide() = default;  ///< only the caller's thread
  /// `executor` must outlive this.
  explicit SideBySide(Executor &executor) : executor_(&executor) {}

  /// Calls job(0) … job(n − 1), each once, in any thread and order; returns when all have returned. Jobs must not touch
  /// each other's data: then the result is the same for any number of threads. Rethrows an exception of a job once all
  /// have ended.
  void each(std::size_t n, const std::function<void(std::size_t)> &job) const;

 private:
  Executor *executor_ = nullptr;
};

}  // namespace csd
