// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <cmath>
#include <cstddef>
#include <vector>

namespace csd {

/// How a test (Eq. 2) divides a node's samples: P1 > P2, P1 = P2, P1 < P2, per class.
struct SplitCounts {
  unsigned feature_greater = 0, feature_equal = 0, feature_less = 0;
  unsigned other_greater = 0, other_equal = 0, other_less = 0;

  bool operator==(const SplitCounts &) const = default;
};

/// Entropy of Eq. 3, H(S) = |S|·log2|S| − |St|·log2|St| − |Sf|·log2|Sf|, weighted by count, with 0·log2 0 = 0.
///
/// k·log2 k comes from a table for k = 0…max_count, rounded to multiples of 2⁻³². Sums of such numbers are exact in a
/// double, so equal entropies compare equal in any order of summation, and a pure set has exactly 0.
class Entropy {
 public:
  explicit Entropy(std::size_t max_count) : k_log2_k_(max_count + 1) {
    for (std::size_t k = 2; k <= max_count; ++k) {
      const auto x = static_cast<double>(k);
      k_log2_k_[k] = std::round(x * std::log2(x) * 0x1p32) * 0x1p-32;
    }
  }

  /// Of a set with `features` samples labelled feature and `others` labelled not a feature; bits times samples.
  double of(std::size_t features, std::size_t others) const {
    return k_log2_k_[features + others] - k_log2_k_[features] - k_log2_k_[others];
  }

  /// Score of a test: the plain sum over its three subsets (Eq. 3 is already weighted by count). 0 is the optimum.
  double of(const SplitCounts &s) const {
    return of(s.feature_greater, s.other_greater) + of(s.feature_equal, s.other_equal) +
           of(s.feature_less, s.other_less);
  }

 private:
  std::vector<double> k_log2_k_;
};

}  // namespace csd
