// SPDX-License-Identifier: LGPL-2.1-or-later
#include "csd2012/learn/pair_search.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>

#include "test_node.h"

namespace csd {
namespace {

// All pairs, straight from Eqs 2 and 3, with the rule for ties.
PairChoice plain_search(const TestNode &f) {
  const Entropy entropy(f.node.size());
  PairChoice best;
  std::uint64_t difference = 0;
  bool first = true;
  for (std::uint16_t i = 0; i < 25; ++i)
    for (auto j = static_cast<std::uint16_t>(i + 1); j < 25; ++j) {
      SplitCounts c;
      std::uint64_t d = 0;
      for (SampleId s = 0; s < f.set.slots(); ++s) {
        const int a = f.set.patch(s)[i], b = f.set.patch(s)[j];
        const bool feature = f.set.label(s) == Label::feature;
        d += static_cast<std::uint64_t>(std::abs(a - b));
        ++(a > b     ? feature ? c.feature_greater : c.other_greater
           : a == b  ? feature ? c.feature_equal : c.other_equal
           : feature ? c.feature_less
                     : c.other_less);
      }
      const double h = entropy.of(c);
      if (first || h < best.entropy || (h == best.entropy && d > difference)) {
        best = {{i, j}, h, c};
        difference = d;
        first = false;
      }
    }
  return best;
}

TEST(PairSearch, TheExhaustiveSearchFindsTheMinimum) {
  for (const int n : {6, 12, 40, 300})
    for (const unsigned levels : {3u, 256u}) {
      TestNode f;
      f.random(n, static_cast<std::uint64_t>(n), levels);
      const PairChoice expected = plain_search(f);
      PairSearchOptions options;
      options.search = PairSearch::exhaustive;
      Random random(1);
      const PairChoice found =
          PairFinder(options).find(f.node, Entropy(f.node.size()), LogTable(f.node.size()), random);
      EXPECT_EQ(found.pair, expected.pair) << n << " " << levels;
      EXPECT_EQ(found.entropy, expected.entropy);
      EXPECT_EQ(found.counts, expected.counts);

      // 25 pixels are fewer than 64, so the ranked search without early exit sees all pairs, too.
      options = {};
      options.stop_at_zero = false;
      const PairChoice ranked =
          PairFinder(options).find(f.node, Entropy(f.node.size()), LogTable(f.node.size()), random);
      EXPECT_EQ(ranked.pair, expected.pair) << n << " " << levels;
    }
}

// Only the order of pixels 4 and 9 separates the classes. Each by itself is noise and ranks low. A random pair finds
// them.
TEST(PairSearch, RandomPairsFindWhatTheRankingMisses) {
  TestNode f;
  Random r(7);
  for (int i = 0; i < 300; ++i) {
    cv::Mat m(5, 5, CV_8UC1);
    for (int p = 0; p < 25; ++p) m.data[p] = static_cast<std::uint8_t>(r.below(256));
    const auto low = static_cast<std::uint8_t>(r.below(255));
    m.data[i % 2 ? 4 : 9] = low;
    m.data[i % 2 ? 9 : 4] = static_cast<std::uint8_t>(low + 1);
    f.add(m, i % 2);
  }
  f.node.gather(f.set, f.features, f.others);
  PairSearchOptions options;
  options.top_pixels = 0;
  options.random_pairs = 4000;  // of 300 pairs: each is drawn
  Random random(1);
  const PairChoice found = PairFinder(options).find(f.node, Entropy(300), LogTable(300), random);
  EXPECT_EQ(found.pair, (PixelPair{4, 9}));
  EXPECT_EQ(found.entropy, 0.0);
  // A pixel is never paired with itself; the smaller index comes first.
  options.random_pairs = 1;
  for (int i = 0; i < 300; ++i) {
    const auto pair = PairFinder(options).find(f.node, Entropy(300), LogTable(300), random).pair;
    EXPECT_LT(pair.p1, pair.p2);
  }
  options.random_pairs = 0;
  EXPECT_EQ(PairFinder(options).find(f.node, Entropy(300), LogTable(300), random).pair, PixelPair{});
}

// Pixels 4, 9 and 14 each separate the classes, and so does each pair of them. By rank, 4 and 9 come first; 4 and 14
// differ most.
TEST(PairSearch, TheRankedSearchStopsAtTheFirstTestOfEntropyZero) {
  TestNode f;
  for (int i = 0; i < 40; ++i) {
    cv::Mat m = cv::Mat::zeros(5, 5, CV_8UC1);
    const bool feature = i % 2;
    m.data[4] = feature ? 60 : 130;
    m.data[9] = feature ? 140 : 80;
    m.data[14] = feature ? 250 : 0;
    f.add(m, feature);
  }
  f.node.gather(f.set, f.features, f.others);
  PairSearchOptions options;
  options.top_pixels = 3;
  options.random_pairs = 0;
  Random random(1);
  EXPECT_EQ(PairFinder(options).find(f.node, Entropy(40), LogTable(40), random).pair, (PixelPair{4, 9}));
  options.stop_at_zero = false;
  EXPECT_EQ(PairFinder(options).find(f.node, Entropy(40), LogTable(40), random).pair, (PixelPair{4, 14}));
}

TEST(PairSearch, TheRankedSearchUsesOnlyTheTopPixelsAndStopsAtZero) {
  TestNode f;
  Random r(6);
  // Pixels 4 and 9 separate the classes by intensity; the rest is noise.
  for (int i = 0; i < 90; ++i) {
    cv::Mat m(5, 5, CV_8UC1);
    for (int p = 0; p < 25; ++p) m.data[p] = static_cast<std::uint8_t>(r.below(256));
    m.data[4] = static_cast<std::uint8_t>((i % 3 ? 200 : 20) + static_cast<int>(r.below(20)));
    m.data[9] = static_cast<std::uint8_t>((i % 3 ? 20 : 200) + static_cast<int>(r.below(20)));
    f.add(m, i % 3 == 0);
  }
  f.node.gather(f.set, f.features, f.others);
  PairSearchOptions options;
  options.top_pixels = 2;
  options.random_pairs = 0;
  Random random(1);
  const PairChoice found = PairFinder(options).find(f.node, Entropy(90), LogTable(90), random);
  EXPECT_EQ(found.pair, (PixelPair{4, 9}));
  EXPECT_EQ(found.entropy, 0.0);
  EXPECT_EQ(found.counts, (SplitCounts{0, 0, 30, 60, 0, 0}));
}

}  // namespace
}  // namespace csd
