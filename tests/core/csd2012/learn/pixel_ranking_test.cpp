// SPDX-License-Identifier: LGPL-2.1-or-later
#include "csd2012/learn/pixel_ranking.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>

#include "test_node.h"

namespace csd {
namespace {

// Eqs 4–6 by hand with t = {.75,.25,0,0}, f = {0,.25,.75,0}: L = ±log(.75/.001) = ±l and 0.
// var(L;t) = .75l² − (.75l)² = .1875l², the same for f; var(L;(t+f)/2) = .75l² − 0; V = .75/.375 = 2.
TEST(PixelRanking, TheVarianceRatioIsAsComputedByHand) {
  const LogTable log(16);
  const std::array<std::uint32_t, 4> t{3, 1, 0, 0}, f{0, 2, 6, 0};
  EXPECT_NEAR(variance_ratio(t, 4, f, 8, log), 2.0, 1e-5);
  EXPECT_NEAR(variance_ratio(f, 8, t, 4, log), 2.0, 1e-5);
  EXPECT_NEAR(variance_ratio(t, 4, t, 4, log), 0.0, 1e-12);
  EXPECT_EQ(variance_ratio(t, 4, std::array<std::uint32_t, 4>{}, 0, log), 0.0);
  // Fully separate: no variance within, only ε in the denominator; var(L;(t+f)/2) = log²(1/δ).
  const std::array<std::uint32_t, 4> a{5, 0, 0, 0}, b{0, 0, 0, 9};
  EXPECT_NEAR(variance_ratio(a, 5, b, 9, log), std::pow(std::log(1000.0), 2) / 1e-6, 1e3);
}

TEST(PixelRanking, BinsFollowTheNode) {
  EXPECT_EQ(histogram_bits(256), 5);
  EXPECT_EQ(histogram_bits(255), 4);
  EXPECT_EQ(histogram_bits(64), 4);
  EXPECT_EQ(histogram_bits(63), 3);
}

// A second implementation of Eqs 4–6, straight from the paper, on probabilities.
double plain_ratio(const TestNode &f, std::size_t pixel, int bins) {
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
    TestNode f;
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

}  // namespace
}  // namespace csd
