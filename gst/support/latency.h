// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace csd {

/// Processing times of frames: percentiles of any number of frames in 8 KiB.
///
/// Times are counted in buckets, 16 per octave, so a percentile is at most 1/16 (6 %) too high and never too low; the
/// maximum is exact. A plain value without locking.
class Latency {
 public:
  void add(std::uint64_t ns);

  /// The time in ns that a fraction `q`, 0…1, of all frames did not exceed. 0 without frames.
  std::uint64_t quantile(double q) const;
  std::uint64_t max() const { return max_; }
  std::uint64_t count() const { return count_; }

 private:
  static constexpr unsigned fraction_bits = 4;
  static constexpr std::size_t buckets = (64 - fraction_bits + 1) << fraction_bits;

  static std::size_t bucket_of(std::uint64_t ns);
  static std::uint64_t last_of(std::size_t bucket);

  std::array<std::uint64_t, buckets> counts_{};
  std::uint64_t count_ = 0, max_ = 0;
};

}  // namespace csd
