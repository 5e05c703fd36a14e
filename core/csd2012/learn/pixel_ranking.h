// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "csd2012/learn/node_samples.h"

namespace csd {

/// Constants of Eqs 4 and 5.
inline constexpr double likelihood_floor = 0.001;  ///< δ of Eq. 4, for histograms of sum 1
inline constexpr double variance_epsilon = 1e-6;   ///< added to the denominator of Eq. 5

/// log(k) for k = 0…max_count (−1e30 for k = 0, below every floor): one table for all histograms of a tree.
class LogTable {
 public:
  explicit LogTable(std::size_t max_count);
  double operator[](std::size_t k) const { return log_[k]; }
  /// log δ
  double floor() const { return floor_; }

 private:
  std::vector<double> log_;
  double floor_;
};

/// log2 of a histogram's number of bins, and the fewest samples for it: 32 bins from 256 samples on, 16 from 64 on,
/// else 8.
struct HistogramSize {
  int bits;
  std::size_t min_samples;
};
inline constexpr std::array<HistogramSize, 3> histogram_sizes{{{5, 256}, {4, 64}, {3, 0}}};
/// The bits for a node of n samples.
int histogram_bits(std::size_t n);

/// The variance ratio V of Eq. 5 of the log likelihood L of Eq. 4. t and f of Eqs 4–6 are given as counts with sums
/// `features` and `others`, and normalised to 1 here. 0 if either is empty. High if the classes separate.
double variance_ratio(std::span<const std::uint32_t> t, std::uint32_t features, std::span<const std::uint32_t> f,
                      std::uint32_t others, const LogTable &log);

/// V of every pixel of the node, from histograms of the node's own samples (§2.2.1, "the currently evaluated set").
/// Resizes `v` to node.pixels(). `log` must cover node.size().
void variance_ratios(const NodeSamples &node, const LogTable &log, std::vector<double> &v);

/// The indices of the `count` highest values, descending; among equals the smaller index first. All if there are fewer.
void rank_pixels(std::span<const double> v, std::size_t count, std::vector<std::uint16_t> &ranked);

}  // namespace csd
