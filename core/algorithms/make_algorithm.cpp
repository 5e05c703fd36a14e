// SPDX-License-Identifier: LGPL-2.1-or-later
// The only file that knows every algorithm. A test of the elements replaces it by its own.
#include "algorithms/make_algorithm.h"

#include <stdexcept>

#include "baselines/collins.h"
#include "baselines/lk.h"
#include "baselines/sift.h"
#include "csd/csd.h"
#include "csd2012/csd2012.h"

namespace csd {

std::unique_ptr<Algorithm> make_algorithm(const Settings &settings, Executor &executor) {
  switch (settings.algorithm) {
    case AlgorithmKind::lk:
      return std::make_unique<LucasKanade>(settings);
    case AlgorithmKind::ms1:
      return std::make_unique<CollinsMeanShift>(settings, ColourRanking::variance_ratio);
    case AlgorithmKind::ms2:
      return std::make_unique<CollinsMeanShift>(settings, ColourRanking::peak_difference);
    case AlgorithmKind::sift:
      return std::make_unique<SiftMatching>(settings);
    case AlgorithmKind::csd:
      return std::make_unique<Csd>(settings, SideBySide(executor));
    case AlgorithmKind::csd_2012:
      return std::make_unique<Csd2012>(settings, executor);
    case AlgorithmKind::csd_forest:
      return std::make_unique<Csd2012>(settings, executor, csd2012::forest_choices());
  }
  throw std::invalid_argument("make_algorithm: no such algorithm");
}

}  // namespace csd
