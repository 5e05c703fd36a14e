// SPDX-License-Identifier: LGPL-2.1-or-later
#include "csd2012/learn/pair_count.h"

#include <algorithm>
#include <cstdlib>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "csd2012/learn/pair_count.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace csd {
namespace HWY_NAMESPACE {

#if HWY_TARGET == HWY_SCALAR  // below SSSE3: without SIMD

void CountPairs(const NodeSamples &node, const PixelPair *pairs, std::size_t n, SplitCounts *counts) {
  count_pairs_scalar(node, {pairs, n}, {counts, n});
}

#else

namespace hn = hwy::HWY_NAMESPACE;

// At most 64 bytes, because runs are padded to 64.
using Bytes = hn::CappedTag<std::uint8_t, NodeSamples::align>;

// Eq. 2 for many patches at once: counts a > b and a == b over n bytes, n a multiple of 64. Each byte lane counts up to
// 255 matches in place. Without mask registers (SSE4, AVX2) this takes half the instructions of a population count per
// vector.
HWY_INLINE void CountRun(const std::uint8_t *HWY_RESTRICT a, const std::uint8_t *HWY_RESTRICT b, std::size_t n,
                         unsigned &greater, unsigned &equal) {
  const Bytes d;
  const std::size_t lanes = hn::Lanes(d);
  const hn::Repartition<std::uint64_t, Bytes> d64;
  auto sum_le = hn::Zero(d64);
  auto sum_eq = hn::Zero(d64);
  for (std::size_t i = 0; i < n;) {
    const std::size_t end = std::min(n, i + 255 * lanes);
    auto le = hn::Zero(d);
    auto eq = hn::Zero(d);
    for (; i < end; i += lanes) {
      const auto va = hn::Load(d, a + i);
      const auto vb = hn::Load(d, b + i);
      // min(a,b) == a means a ≤ b: an unsigned comparison without the sign flips that SSE and AVX2 need for >.
      le = hn::Sub(le, hn::VecFromMask(d, hn::Eq(hn::Min(va, vb), va)));
      eq = hn::Sub(eq, hn::VecFromMask(d, hn::Eq(va, vb)));
    }
    sum_le = hn::Add(sum_le, hn::SumsOf8(le));
    sum_eq = hn::Add(sum_eq, hn::SumsOf8(eq));
  }
  greater = static_cast<unsigned>(n - hn::GetLane(hn::SumOfLanes(d64, sum_le)));
  equal = static_cast<unsigned>(hn::GetLane(hn::SumOfLanes(d64, sum_eq)));
}

void CountPairs(const NodeSamples &node, const PixelPair *pairs, std::size_t n, SplitCounts *counts) {
  const std::size_t feature_bytes = node.feature_bytes(), other_bytes = node.other_bytes();
  const auto features = static_cast<unsigned>(node.features()), others = static_cast<unsigned>(node.others());
  const auto feature_padding = static_cast<unsigned>(feature_bytes) - features;
  const auto other_padding = static_cast<unsigned>(other_bytes) - others;
  for (std::size_t i = 0; i < n; ++i) {
    SplitCounts c;
    const auto [p1, p2] = pairs[i];
    CountRun(node.feature_row(p1), node.feature_row(p2), feature_bytes, c.feature_greater, c.feature_equal);
    CountRun(node.other_row(p1), node.other_row(p2), other_bytes, c.other_greater, c.other_equal);
    c.feature_equal -= feature_padding;
    c.feature_less = features - c.feature_greater - c.feature_equal;
    c.other_equal -= other_padding;
    c.other_less = others - c.other_greater - c.other_equal;
    counts[i] = c;
  }
}

#endif

}  // namespace HWY_NAMESPACE
}  // namespace csd
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace csd {

HWY_EXPORT(CountPairs);

void count_pairs(const NodeSamples &node, std::span<const PixelPair> pairs, std::span<SplitCounts> counts) {
  HWY_DYNAMIC_DISPATCH(CountPairs)(node, pairs.data(), std::min(pairs.size(), counts.size()), counts.data());
}

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
#endif  // HWY_ONCE
