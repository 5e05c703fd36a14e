// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <vector>

#include "score/clip.h"

namespace csd::score {

/// Distances in pixels of the positions claimed of visible features, in moments begin…end−1.
std::vector<double> claimed_errors(const Clip &clip, std::size_t begin, std::size_t end);
std::vector<double> claimed_errors(const Clip &clip);

/// Errors of the first and of the last fifth of the labelled frames (rounded up): drift is by how much the second's
/// median is above the first's.
struct DriftErrors {
  std::vector<double> first, last;
};
DriftErrors drift_errors(const Clip &clip);

}  // namespace csd::score
