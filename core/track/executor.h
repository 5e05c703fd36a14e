// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <functional>

namespace csd {

/// Runs work outside the caller's thread. The core starts no threads of its own: it is given an Executor.
class Executor {
 public:
  virtual ~Executor() = default;
  /// Runs `job` once, soon, in any thread. Jobs must not throw.
  virtual void post(std::function<void()> job) = 0;
  /// Number of jobs that may run at once.
  virtual unsigned width() const { return 1; }
};

}  // namespace csd
