// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <cstddef>
#include <functional>

#include "track/executor.h"

namespace csd {

/// Work of one frame on several threads: the caller's, and those of an executor that have nothing else to do. The
/// caller waits for none that has not begun, so where all are busy it does everything by itself.
class SideBySide {
 public:
  SideBySide() = default;  ///< the caller's thread alone
  /// `executor` must outlive this.
  explicit SideBySide(Executor &executor) : executor_(&executor) {}

  /// Calls job(0) … job(n − 1), each once, in any thread and order; returns when all have returned. They must not touch
  /// what others change: then the result is the same for every number of threads. What one throws is thrown here, once
  /// all have ended.
  void each(std::size_t n, const std::function<void(std::size_t)> &job) const;

 private:
  Executor *executor_ = nullptr;
};

}  // namespace csd
