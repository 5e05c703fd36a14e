// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <functional>

namespace csd {

/// Where work runs that is not the caller's thread's. The core starts no thread of its own: it is given one of these.
class Executor {
 public:
  virtual ~Executor() = default;
  /// Runs `job` soon, in any thread, once. Jobs must not throw.
  virtual void post(std::function<void()> job) = 0;
  /// How many jobs may run at once.
  virtual unsigned width() const { return 1; }
};

}  // namespace csd
