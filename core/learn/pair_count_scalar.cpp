// SPDX-License-Identifier: LGPL-2.1-or-later
#include <cstdlib>

#include "learn/pair_count.h"

namespace csd {

namespace {

void count_run(const std::uint8_t *a, const std::uint8_t *b, std::size_t n, unsigned &greater, unsigned &equal,
               unsigned &less) {
  greater = equal = less = 0;
  for (std::size_t i = 0; i < n; ++i) {
    greater += a[i] > b[i];
    equal += a[i] == b[i];
    less += a[i] < b[i];
  }
}

}  // namespace

void count_pairs_scalar(const NodeSamples &node, std::span<const PixelPair> pairs, std::span<SplitCounts> counts) {
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    const auto [p1, p2] = pairs[i];
    SplitCounts &c = counts[i];
    count_run(node.feature_row(p1), node.feature_row(p2), node.features(), c.feature_greater, c.feature_equal,
              c.feature_less);
    count_run(node.other_row(p1), node.other_row(p2), node.others(), c.other_greater, c.other_equal, c.other_less);
  }
}

std::uint64_t sum_of_differences(const NodeSamples &node, PixelPair pair) {
  const auto run = [](const std::uint8_t *a, const std::uint8_t *b, std::size_t n) {
    std::uint32_t sum = 0;
    for (std::size_t i = 0; i < n; ++i) sum += static_cast<std::uint32_t>(std::abs(a[i] - b[i]));
    return sum;
  };
  return std::uint64_t{run(node.feature_row(pair.p1), node.feature_row(pair.p2), node.features())} +
         run(node.other_row(pair.p1), node.other_row(pair.p2), node.others());
}

}  // namespace csd
