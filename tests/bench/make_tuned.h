// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <memory>

#include "algorithms/make_algorithm.h"
#include "csd/csd.h"
#include "csd2012/csd2012.h"
#include "track/side_by_side.h"
#include "track/thread_pool.h"

namespace csd::bench {

/// The algorithm of the settings with the numbers of a bench's --set.
inline std::unique_ptr<Algorithm> make_tuned(const Settings &settings, const Tuning &tuning,
                                             const csd2012::Choices &choices, ThreadPool &pool,
                                             SideBySide workers = {}) {
  switch (settings.algorithm) {
    case AlgorithmKind::csd:
      return std::make_unique<Csd>(settings, workers, tuning);
    case AlgorithmKind::csd_2012:
    case AlgorithmKind::csd_forest:
      return std::make_unique<Csd2012>(settings, pool, choices);
    default:
      return make_algorithm(settings, pool);
  }
}

}  // namespace csd::bench
