// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <vector>

#include "score/clip.h"

namespace csd::score {

/// Errors in pixels of the claims on visible features, in moments begin…end−1.
std::vector<double> claimed_errors(const Clip &clip, std::size_t begin, std::size_t end);
std::vector<double> claimed_errors(const Clip &clip);

/// Errors in the first and the last fifth of the labelled frames (rounded up): drift is the median of the second minus
/// that of the first.
struct DriftErrors {
  std::vector<double> first, last;
};
DriftErrors drift_errors(const Clip &clip);

}  // namespace csd::score
