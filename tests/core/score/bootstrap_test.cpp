// SPDX-License-Identifier: LGPL-2.1-or-later
#include "score/bootstrap.h"

#include <gtest/gtest.h>

#include "score/samples.h"

namespace csd::score {
namespace {

constexpr auto sensitivity = static_cast<std::size_t>(Headline::sensitivity);
constexpr unsigned draws = 20000;

std::vector<ClipStatistics> statistics(const std::vector<Clip> &clips) {
  return {clips.begin(), clips.end()};
}

TEST(Bootstrap, DrawsFeaturesOfOneClip) {
  // One frame, 4 features, one of them correct: a draw's sensitivity is Binomial(4, 1/4) / 4.
  const auto clips = statistics({clip_of(640, 480, {{seen(0)}, {seen(9)}, {seen(9)}, {seen(9)}})});
  const auto drawn = bootstrap(clips, draws, 7);
  std::array<double, 5> share{};
  for (const Headlines &draw : drawn) share[static_cast<std::size_t>(std::lround(4 * draw[sensitivity]))] += 1. / draws;
  const std::array<double, 5> binomial{81. / 256, 108. / 256, 54. / 256, 12. / 256, 1. / 256};
  // The standard error of a share is at most .0035.
  for (std::size_t i = 0; i < 5; ++i) EXPECT_NEAR(share[i], binomial[i], .0125) << i;
  EXPECT_EQ(headlines(clips)[sensitivity], .25);
}

TEST(Bootstrap, DrawsClipsToo) {
  // Two clips of one feature each, one wholly correct and one wholly wrong: ¼ both wrong, ½ one of each, ¼ both
  // correct.
  const auto clips = statistics({clip_of(640, 480, {{seen(0)}}), clip_of(640, 480, {{seen(9)}})});
  std::array<double, 3> share{};
  for (const Headlines &draw : bootstrap(clips, draws, 7))
    share[static_cast<std::size_t>(std::lround(2 * draw[sensitivity]))] += 1. / draws;
  EXPECT_NEAR(share[0], .25, .0125);
  EXPECT_NEAR(share[1], .5, .0125);
  EXPECT_NEAR(share[2], .25, .0125);
}

TEST(Bootstrap, MeansOverClipsIgnoreTheirSize) {
  const auto clips = statistics({clip_of(640, 480, {{seen(0)}}), clip_of(640, 480, {{seen(9)}, {seen(9)}, {seen(9)}})});
  EXPECT_EQ(headlines(clips)[sensitivity], .5);
}

TEST(Bootstrap, OneFeatureOfOneClipHasNoVariance) {
  const auto clips = statistics({clip_of(640, 480, {{seen(0)}})});
  const auto drawn = bootstrap(clips, 100, 7);
  EXPECT_TRUE(std::isnan(interval(drawn, sensitivity).low));
  EXPECT_TRUE(std::isnan(compare(1, drawn, 1, drawn, sensitivity, 1).p));
}

TEST(Bootstrap, TheIntervalHolds95PercentOfTheDraws) {
  std::vector<Headlines> drawn(1001);
  for (std::size_t i = 0; i < drawn.size(); ++i) drawn[i].fill(static_cast<double>(1000 - i));
  const Interval found = interval(drawn, sensitivity);
  EXPECT_NEAR(found.low, 25, 1e-9);
  EXPECT_NEAR(found.high, 975, 1e-9);
}

TEST(Comparison, PairsTheDraws) {
  // b is correct where a is, and on one of 4 more features. The difference is 0 only in draws without that one, (3/4)⁴
  // = .3164 of them, and never below. Unpaired draws would often be below.
  const auto a = statistics({clip_of(640, 480, {{seen(0)}, {seen(0)}, {seen(9)}, {seen(9)}})});
  const auto b = statistics({clip_of(640, 480, {{seen(0)}, {seen(0)}, {seen(0)}, {seen(9)}})});
  const auto draws_a = bootstrap(a, draws, 7), draws_b = bootstrap(b, draws, 7);
  const Comparison found = compare(.75, draws_b, .5, draws_a, sensitivity, 4);
  EXPECT_EQ(found.difference, .25);
  EXPECT_NEAR(found.p, 2 * .3164, .025);
  EXPECT_EQ(found.confidence.low, 0);
}

TEST(Comparison, EqualTrackersDoNotDiffer) {
  const auto a = statistics({clip_of(640, 480, {{seen(0)}, {seen(9)}, {seen(9)}})});
  const auto drawn = bootstrap(a, 1000, 7);
  EXPECT_EQ(compare(1. / 3, drawn, 1. / 3, drawn, sensitivity, 3).p, 1);
}

TEST(Comparison, ADifferenceInEveryDrawHasTheSmallestP) {
  const std::vector<Headlines> a(999, Headlines{}), b(999, {1, 1, 1, 1, 1, 1});
  EXPECT_EQ(compare(1, b, 0, a, sensitivity, 50).p, 2. / 1000);
  EXPECT_EQ(compare(0, a, 1, b, sensitivity, 50).p, 2. / 1000) << "two-sided";
}

TEST(Comparison, FewFeaturesCannotHaveASmallP) {
  const std::vector<Headlines> a(999, Headlines{}), b(999, {1, 1, 1, 1, 1, 1});
  EXPECT_EQ(compare(1, b, 0, a, sensitivity, 2).p, .5);
  EXPECT_EQ(compare(1, b, 0, a, sensitivity, 5).p, .0625)
      << "of the 32 signs that 5 differences can have, 2 are as extreme";
}

}  // namespace
}  // namespace csd::score
