// SPDX-License-Identifier: LGPL-2.1-or-later
#include "csd2012/learn/leaf_patches.h"

#include <algorithm>
#include <cmath>

namespace csd {
namespace {

/// Fits: a patch has at most 255² pixels, each product is at most 255².
std::uint32_t dot(const std::uint8_t *a, const std::uint8_t *b, std::size_t n) {
  std::uint32_t sum = 0;
  for (std::size_t i = 0; i < n; ++i) sum += std::uint32_t{a[i]} * b[i];
  return sum;
}

std::uint32_t sum_of(const std::uint8_t *a, std::size_t n) {
  std::uint32_t sum = 0;
  for (std::size_t i = 0; i < n; ++i) sum += a[i];
  return sum;
}

double inverse_spread(double n, double sum, double squares) {
  const double spread = n * squares - sum * sum;
  return spread > 0 ? 1 / std::sqrt(spread) : 0;
}

}  // namespace

void LeafPatches::add(const std::uint8_t *patch) {
  bytes_.insert(bytes_.end(), patch, patch + pixels_);
  sums_.push_back(sum_of(patch, pixels_));
  inverse_spread_.push_back(inverse_spread(static_cast<double>(pixels_), sums_.back(), dot(patch, patch, pixels_)));
}

double LeafPatches::likeness(const std::uint8_t *patch) const {
  const auto n = static_cast<double>(pixels_);
  const double sum = sum_of(patch, pixels_), own = inverse_spread(n, sum, dot(patch, patch, pixels_));
  double best = 0;
  for (std::size_t k = 0; k < size(); ++k) {
    const double product = n * dot(patch, bytes_.data() + k * pixels_, pixels_) - sum * sums_[k];
    best = std::max(best, product * own * inverse_spread_[k]);
  }
  return best;
}

}  // namespace csd
