// SPDX-License-Identifier: LGPL-2.1-or-later
#include <gtest/gtest.h>

#include <cmath>

#include "learn/pair_search.h"

namespace csd {
namespace {

TEST(Entropy, Equation3ByHand) {
  const Entropy h(64);
  EXPECT_EQ(h.of(0, 0), 0.0);
  EXPECT_EQ(h.of(1, 0), 0.0);
  EXPECT_EQ(h.of(0, 37), 0.0);
  EXPECT_EQ(h.of(1, 1), 2.0);                                    // 2·log2 2
  EXPECT_EQ(h.of(8, 8), 16.0);                                   // 16·4 − 8·3 − 8·3
  EXPECT_NEAR(h.of(1, 3), 8 - 3 * std::log2(3.0), 1e-8);         // 4·2 − 0 − 3·log2 3
  EXPECT_EQ(h.of(SplitCounts{8, 0, 1, 8, 5, 1}), 16.0 + 0 + 2);  // plain sum over the three subsets
  EXPECT_EQ(h.of(3, 7) + h.of(11, 5), h.of(5, 11) + h.of(7, 3));
}

// Eqs 4–6 by hand with t = {.75,.25,0,0}, f = {0,.25,.75,0}: L = ±log(.75/.001) = ±l and 0.
// var(L;t) = .75l² − (.75l)² = .1875l², the same for f; var(L;(t+f)/2) = .75l² − 0; V = .75/.375 = 2.
TEST(PixelRanking, VarianceRatioByHand) {
  const LogTable log(16);
  const std::array<std::uint32_t, 4> t{3, 1, 0, 0}, f{0, 2, 6, 0};
  EXPECT_NEAR(variance_ratio(t, 4, f, 8, log), 2.0, 1e-5);
  EXPECT_NEAR(variance_ratio(f, 8, t, 4, log), 2.0, 1e-5);
  EXPECT_NEAR(variance_ratio(t, 4, t, 4, log), 0.0, 1e-12);
  EXPECT_EQ(variance_ratio(t, 4, std::array<std::uint32_t, 4>{}, 0, log), 0.0);
  // Fully apart: no variance within, only ε in the denominator; var(L;(t+f)/2) = log²(1/δ).
  const std::array<std::uint32_t, 4> a{5, 0, 0, 0}, b{0, 0, 0, 9};
  EXPECT_NEAR(variance_ratio(a, 5, b, 9, log), std::pow(std::log(1000.0), 2) / 1e-6, 1e3);
}

TEST(PixelRanking, BinsFollowTheNode) {
  EXPECT_EQ(histogram_bits(256), 5);
  EXPECT_EQ(histogram_bits(255), 4);
  EXPECT_EQ(histogram_bits(64), 4);
  EXPECT_EQ(histogram_bits(63), 3);
}

struct Fixture {
  SampleSet set{5};
  std::vector<SampleId> features, others;
  NodeSamples node;

  void add(const cv::Mat &m, bool feature) {
    (feature ? features : others).push_back(set.add(m, feature ? Label::feature : Label::not_feature));
  }
  void random(int n, std::uint64_t seed, unsigned levels = 256) {
    Random r(seed);
    for (int i = 0; i < n; ++i) {
      cv::Mat m(5, 5, CV_8UC1);
      for (int p = 0; p < 25; ++p) m.data[p] = static_cast<std::uint8_t>(r.below(levels));
      add(m, i % 3 == 0);
    }
    node.gather(set, features, others);
  }
};

// A second implementation of Eqs 4–6, straight from the paper, on probabilities.
double plain_ratio(const Fixture &f, std::size_t pixel, int bins) {
  std::vector<double> t(static_cast<std::size_t>(bins)), o(t), l(t), m(t);
  for (const SampleId i : f.features) t[static_cast<std::size_t>(f.set.patch(i)[pixel] * bins / 256)] += 1.0;
  for (const SampleId i : f.others) o[static_cast<std::size_t>(f.set.patch(i)[pixel] * bins / 256)] += 1.0;
  for (std::size_t i = 0; i < t.size(); ++i) {
    t[i] /= static_cast<double>(f.features.size());
    o[i] /= static_cast<double>(f.others.size());
    l[i] = std::log(std::max(t[i], .001) / std::max(o[i], .001));
    m[i] = (t[i] + o[i]) / 2;
  }
  const auto var = [&](const std::vector<double> &a) {
    double squares = 0, sum = 0;
    for (std::size_t i = 0; i < a.size(); ++i) {
      squares += a[i] * l[i] * l[i];
      sum += a[i] * l[i];
    }
    return squares - sum * sum;
  };
  return var(m) / (var(t) + var(o) + 1e-6);
}

TEST(PixelRanking, AgreesWithThePlainFormula) {
  for (const auto &[n, bins] : {std::pair{50, 8}, {131, 16}, {700, 32}}) {
    Fixture f;
    f.random(n, 4);
    const LogTable log(f.node.size());
    std::vector<double> v;
    variance_ratios(f.node, log, v);
    ASSERT_EQ(v.size(), 25u);
    for (std::size_t p = 0; p < 25; ++p) EXPECT_NEAR(v[p], plain_ratio(f, p, bins), 1e-9 * (1 + v[p])) << n << " " << p;
  }
}

TEST(PixelRanking, RanksByValueThenIndex) {
  const std::array<double, 5> v{.5, 2, .5, 3, .5};
  std::vector<std::uint16_t> ranked;
  rank_pixels(v, 4, ranked);
  EXPECT_EQ(ranked, (std::vector<std::uint16_t>{3, 1, 0, 2}));
  rank_pixels(v, 9, ranked);
  EXPECT_EQ(ranked.size(), 5u);
}

// All pairs, straight from Eqs 2 and 3, with the tie rule.
PairChoice plain_search(const Fixture &f) {
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

TEST(PairSearch, ExhaustiveIsTheMinimum) {
  for (const int n : {6, 12, 40, 300})
    for (const unsigned levels : {3u, 256u}) {
      Fixture f;
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

      // 25 pixels are fewer than 64, so ranked search without an early exit sees all pairs, too.
      options = {};
      options.stop_at_zero = false;
      const PairChoice ranked =
          PairFinder(options).find(f.node, Entropy(f.node.size()), LogTable(f.node.size()), random);
      EXPECT_EQ(ranked.pair, expected.pair) << n << " " << levels;
    }
}

TEST(PairSearch, RankedStaysWithinTheTopPixelsAndStopsAtZero) {
  Fixture f;
  Random r(6);
  // Pixels 4 and 9 tell the classes apart by intensity, the rest is noise.
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
