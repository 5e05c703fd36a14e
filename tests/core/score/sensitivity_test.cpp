// SPDX-License-Identifier: LGPL-2.1-or-later
#include "score/sensitivity.h"

#include <gtest/gtest.h>

#include "score/samples.h"

namespace csd::score {
namespace {

TEST(Sensitivity, ComparesClaimsWithTheTruth) {
  const Clip clip = clip_of(
      640, 480,
      {{seen(3, 4)}, {seen(3, 4.01)}, {missed(0)}, {ghost()}, {ghost(Presence::out)}, {quiet()}, {unlabelled()}});
  const auto frames = count_frames(Outcomes(clip, 5));
  ASSERT_EQ(frames.size(), 1u);
  EXPECT_EQ(frames[0].correct, 1u) << "5 px off is correct: the threshold is included";
  EXPECT_EQ(frames[0].wrong, 1u);
  EXPECT_EQ(frames[0].missed, 1u);
  EXPECT_EQ(frames[0].on_hidden, 2u);
  EXPECT_EQ(frames[0].quiet, 1u);
  EXPECT_DOUBLE_EQ(frames[0].sensitivity(), 1. / 3);
  EXPECT_DOUBLE_EQ(frames[0].k(), 3. / 4) << "a claim on a hidden point is wrong";
  EXPECT_DOUBLE_EQ(frames[0].k_visible(), 1. / 2);
  EXPECT_DOUBLE_EQ(frames[0].hidden_claimed(), 2. / 3);
}

TEST(Sensitivity, IsTheMeanOverFramesNotOverSamples) {
  // Frame 0: 1 of 1 correct. Frame 1: 1 of 3. Pooled it would be 2 of 4.
  const Clip clip = clip_of(640, 480, {{seen(0), seen(0)}, {quiet(), seen(9)}, {quiet(), missed(0)}});
  const PaperScore score = paper_score(count_frames(Outcomes(clip, 5)));
  EXPECT_DOUBLE_EQ(score.sensitivity, (1 + 1. / 3) / 2);
  EXPECT_DOUBLE_EQ(score.k, (0 + 1. / 2) / 2);
}

TEST(Sensitivity, LeavesOutFramesWithoutPointsOrClaims) {
  // Frame 0: nothing visible, one claim, so no sensitivity, and K = 1. Frame 1: nothing claimed, so sensitivity 0 and
  // no K.
  const Clip clip = clip_of(640, 480, {{ghost(), missed(0)}, {quiet(), missed(0)}});
  const PaperScore score = paper_score(count_frames(Outcomes(clip, 5)));
  EXPECT_EQ(score.sensitivity, 0);
  EXPECT_EQ(score.k, 1);
  EXPECT_TRUE(std::isnan(score.k_visible));
}

TEST(Sensitivity, ThresholdsGrowAbove576Lines) {
  EXPECT_EQ(tolerance(288, 5), 5);
  EXPECT_EQ(tolerance(576, 5), 5);
  EXPECT_EQ(tolerance(1152, 5), 10);
}

TEST(Sensitivity, WeightsRepeatFeatures) {
  // Weights 2, 0, 1 are the clip {a, a, c}.
  const std::vector<Sample> a{seen(0), seen(7), ghost()}, b{missed(0), seen(0), quiet()},
      c{seen(6), missed(1), seen(1)};
  const std::vector<std::uint32_t> weights{2, 0, 1};
  const PaperScore weighted = paper_score(Outcomes(clip_of(640, 480, {a, b, c}), 5), weights);
  // a, a, c: sensitivity 2/3, 0/3, 1/1; K 1/3, 2/2, 2/3.
  EXPECT_DOUBLE_EQ(weighted.sensitivity, (2. / 3 + 0 + 1) / 3);
  EXPECT_DOUBLE_EQ(weighted.k, (1. / 3 + 1 + 2. / 3) / 3);
  const std::vector<std::uint32_t> once{1};
  EXPECT_TRUE(std::isnan(paper_score(Outcomes(clip_of(640, 480, {{missed(0)}}), 5), once).k));
  EXPECT_TRUE(std::isnan(paper_score(Outcomes(clip_of(640, 480, {{ghost()}}), 5), once).sensitivity));
}

}  // namespace
}  // namespace csd::score
