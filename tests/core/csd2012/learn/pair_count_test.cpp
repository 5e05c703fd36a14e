// SPDX-License-Identifier: LGPL-2.1-or-later
#include "csd2012/learn/pair_count.h"

#include <gtest/gtest.h>

#include <array>
#include <cstdlib>

#include "base/random.h"
#include "core/simd_targets.h"

namespace csd {
namespace {

struct Fixture {
  SampleSet set{5};
  std::vector<SampleId> features, others;
  NodeSamples node;

  Fixture(std::size_t n_features, std::size_t n_others, unsigned levels, std::uint64_t seed) {
    Random random(seed);
    for (std::size_t i = 0; i < n_features + n_others; ++i) {
      cv::Mat m(5, 5, CV_8UC1);
      for (int p = 0; p < 25; ++p) m.data[p] = static_cast<std::uint8_t>(random.below(levels) * (255 / (levels - 1)));
      const bool feature = i % 2 ? features.size() < n_features : others.size() >= n_others;
      (feature ? features : others).push_back(set.add(m, feature ? Label::feature : Label::not_feature));
    }
    node.gather(set, features, others);
  }
};

TEST(PairCount, IsAsComputedByHand) {
  SampleSet set(3);
  const auto add = [&](int a, int b, Label label) {
    cv::Mat m = cv::Mat::zeros(3, 3, CV_8UC1);
    m.data[2] = static_cast<std::uint8_t>(a);
    m.data[8] = static_cast<std::uint8_t>(b);
    return set.add(m, label);
  };
  const std::vector<SampleId> features{add(255, 0, Label::feature), add(128, 127, Label::feature),
                                       add(7, 7, Label::feature)};
  const std::vector<SampleId> others{add(0, 255, Label::not_feature), add(127, 128, Label::not_feature),
                                     add(0, 0, Label::not_feature), add(255, 255, Label::not_feature)};
  NodeSamples node;
  node.gather(set, features, others);
  const std::array<PixelPair, 1> pair{{{2, 8}}};
  std::array<SplitCounts, 1> counts;
  const SplitCounts expected{2, 1, 0, 0, 2, 2};
  count_pairs(node, pair, counts);
  EXPECT_EQ(counts[0], expected);
  count_pairs_scalar(node, pair, counts);
  EXPECT_EQ(counts[0], expected);
  EXPECT_EQ(sum_of_differences(node, pair[0]), 255u + 1 + 0 + 255 + 1 + 0 + 0);
}

// Lengths around those of vectors and padding, and beyond the 255 vectors that a byte lane can count.
void agrees_with_the_plain_twin() {
  std::uint64_t seed = 1;
  std::vector<std::array<std::size_t, 2>> lengths;
  for (std::size_t n = 0; n <= 130; n += n < 3 ? 1 : 13) lengths.push_back({n, 131 - n});
  lengths.insert(lengths.end(), {{63, 64}, {64, 65}, {65, 1}, {4100, 100}, {30, 17000}});
  for (const auto [n, m] : lengths)
    for (const unsigned levels : {2u, 6u, 256u}) {
      const Fixture f(n, m, levels, seed++);
      std::vector<PixelPair> pairs;
      for (std::uint16_t i = 0; i < 25; ++i)
        for (std::uint16_t j = 0; j < 25; j = static_cast<std::uint16_t>(j + 3)) pairs.push_back({i, j});
      std::vector<SplitCounts> simd(pairs.size()), plain(pairs.size());
      count_pairs(f.node, pairs, simd);
      count_pairs_scalar(f.node, pairs, plain);
      EXPECT_EQ(simd, plain) << n << " " << m << " " << levels;
    }
}

TEST(PairCount, AgreesWithItsPlainTwinAtEveryLength) {
  test::on_all_targets(agrees_with_the_plain_twin);
}

}  // namespace
}  // namespace csd
