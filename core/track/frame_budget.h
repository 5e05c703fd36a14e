// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <functional>

namespace csd {

/// Time limit for the tracking of a frame, starting at construction.
class FrameBudget {
 public:
  using Clock = std::function<std::int64_t()>;  ///< ns; never decreases

  FrameBudget() = default;  ///< none: never spent
  /// `budget` in ns, 0: none. `clock` must outlive this; empty: the steady clock.
  FrameBudget(std::int64_t budget, const Clock &clock) : budget_(budget), clock_(&clock) {
    if (budget_ > 0) begun_ = now();
  }

  bool limited() const { return budget_ > 0; }
  /// Once spent it stays so, and the clock is no longer read.
  bool spent() const { return limited() && (spent_ = spent_ || now() - begun_ >= budget_); }
  /// A share of the time, 0…1, from the same start.
  FrameBudget share(double part) const {
    FrameBudget out = *this;
    if (limited())
      out.budget_ = std::max<std::int64_t>(1, static_cast<std::int64_t>(static_cast<double>(budget_) * part));
    return out;
  }

 private:
  std::int64_t now() const {
    if (*clock_) return (*clock_)();
    return std::chrono::nanoseconds(std::chrono::steady_clock::now().time_since_epoch()).count();
  }

  std::int64_t budget_ = 0, begun_ = 0;
  mutable bool spent_ = false;
  const Clock *clock_ = nullptr;
};

}  // namespace csd
