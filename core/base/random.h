// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <cstdint>

namespace csd {

/// A small generator (SplitMix64; Steele, Lea, Flood 2014) with the same numbers on every machine: it uses only integer
/// arithmetic and exactly rounded operations, no library functions. Not for cryptography.
class Random {
 public:
  /// An independent stream for each pair of numbers, e.g. the tracker's seed and a feature's id.
  explicit Random(std::uint64_t seed, std::uint64_t stream = 0) : state_(mix(mix(seed) + gamma * (stream + 1))) {}

  /// Uniform over all 64-bit numbers.
  std::uint64_t next() { return mix(state_ += gamma); }

  /// Uniform in 0…n−1; n > 0. (Multiply and shift: the bias is below n/2³².)
  std::uint32_t below(std::uint32_t n) {
    return static_cast<std::uint32_t>((static_cast<std::uint64_t>(next() >> 32) * n) >> 32);
  }

  /// Uniform in [0,1), 53 bits.
  double uniform() { return static_cast<double>(next() >> 11) * 0x1p-53; }
  /// Uniform in [low,high).
  double uniform(double low, double high) { return low + (high - low) * uniform(); }

  /// Standard normal as the sum of 12 uniform 16-bit numbers (Irwin–Hall): mean 0, variance 1 − 2⁻³², |z| ≤ 6.
  /// Not Box–Muller, because log and cos differ in the last bit between machines.
  double normal() {
    std::int64_t sum = -12 * 65535 / 2;
    for (int i = 0; i < 3; ++i) {
      const std::uint64_t bits = next();
      sum +=
          static_cast<std::int64_t>((bits & 0xffff) + ((bits >> 16) & 0xffff) + ((bits >> 32) & 0xffff) + (bits >> 48));
    }
    return static_cast<double>(sum) * 0x1p-16;
  }

 private:
  static constexpr std::uint64_t gamma = 0x9e3779b97f4a7c15u;

  static std::uint64_t mix(std::uint64_t z) {
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
    return z ^ (z >> 31);
  }

  std::uint64_t state_;
};

}  // namespace csd
