// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <hwy/targets.h>

#include <cstdint>

namespace csd::test {

/// Makes Highway dispatch to one target while it lives.
class OnTarget {
 public:
  explicit OnTarget(std::int64_t target) { choose(target); }
  ~OnTarget() { choose(0); }
  OnTarget(const OnTarget &) = delete;
  OnTarget &operator=(const OnTarget &) = delete;

 private:
  static void choose(std::int64_t target) {
    hwy::SetSupportedTargetsForTest(target);
    hwy::GetChosenTarget().Update(hwy::SupportedTargets());
  }
};

}  // namespace csd::test
