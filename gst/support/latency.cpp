// SPDX-License-Identifier: LGPL-2.1-or-later
#include "support/latency.h"

#include <algorithm>
#include <bit>
#include <cmath>

namespace csd {

// Values below 2^fraction_bits have a bucket each. Above, a bucket is the value's leading fraction_bits + 1 bits: the
// number of bits shifted out gives the octave, the bits after the leading one the position in it.
std::size_t Latency::bucket_of(std::uint64_t ns) {
  const auto width = static_cast<unsigned>(std::bit_width(ns));
  if (width <= fraction_bits) return static_cast<std::size_t>(ns);
  const unsigned shift = width - 1 - fraction_bits;
  return static_cast<std::size_t>((std::uint64_t{shift} << fraction_bits) + (ns >> shift));
}

std::uint64_t Latency::last_of(std::size_t bucket) {
  constexpr std::size_t octave = std::size_t{1} << fraction_bits;
  if (bucket < 2 * octave) return bucket;
  const auto shift = static_cast<unsigned>(bucket / octave) - 1;
  const std::uint64_t leading = bucket - (std::uint64_t{shift} << fraction_bits);
  return ((leading + 1) << shift) - 1;  // wraps to the largest value in the last bucket, as intended
}

void Latency::add(std::uint64_t ns) {
  ++counts_[bucket_of(ns)];
  ++count_;
  max_ = std::max(max_, ns);
}

std::uint64_t Latency::quantile(double q) const {
  if (count_ == 0) return 0;
  const auto rank =
      std::clamp<std::uint64_t>(static_cast<std::uint64_t>(std::ceil(q * static_cast<double>(count_))), 1, count_);
  std::uint64_t seen = 0;
  for (std::size_t bucket = 0; bucket < buckets; ++bucket) {
    seen += counts_[bucket];
    if (seen >= rank) return std::min(last_of(bucket), max_);
  }
  return max_;
}

}  // namespace csd
