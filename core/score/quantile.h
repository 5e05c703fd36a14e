// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

#include "score/types.h"

namespace csd::score {

/// The q-quantile, 0…1, of values that may be infinite, interpolated between neighbours (R's type 7, numpy's default).
/// Unknown without values.
inline double quantile(std::vector<double> values, double q) {
  if (values.empty()) return unknown;
  const double at = q * static_cast<double>(values.size() - 1);
  const auto low = values.begin() + static_cast<std::ptrdiff_t>(at);
  std::nth_element(values.begin(), low, values.end());
  const double below = *low, part = at - std::floor(at);
  if (part == 0) return below;
  const double above = *std::min_element(low + 1, values.end());
  return below == above ? below : below + part * (above - below);
}

/// The mean of the known values; unknown without any.
inline double mean_of_known(const std::vector<double> &values) {
  double sum = 0;
  std::size_t count = 0;
  for (const double value : values)
    if (!std::isnan(value)) {
      sum += value;
      ++count;
    }
  return count ? sum / static_cast<double>(count) : unknown;
}

}  // namespace csd::score
