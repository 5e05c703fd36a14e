// SPDX-License-Identifier: LGPL-2.1-or-later
#include "score/tap_vid.h"

#include <gtest/gtest.h>

#include "score/samples.h"

namespace csd::score {
namespace {

JaccardSums all(const Clip &clip) {
  JaccardSums sums;
  for (const JaccardSums &feature : tap_vid_sums(clip)) sums.add(feature);
  return sums;
}

TEST(TapVid, MeasuresInAPictureOf256By256) {
  // In 640×512, 5 px to the right scale to 2, and 4 px down, too. Strictly below: 2 is not within 2.
  const Clip right = clip_of(640, 512, {{seen(0), seen(5)}});
  EXPECT_EQ(all(right).within, (std::array<std::uint64_t, 5>{0, 0, 1, 1, 1}));
  const Clip down = clip_of(640, 512, {{seen(0), seen(0, 4)}});
  EXPECT_EQ(all(down).within, (std::array<std::uint64_t, 5>{0, 0, 1, 1, 1}));
  const Clip nearer = clip_of(640, 512, {{seen(0), seen(0, 3.99)}});
  EXPECT_EQ(all(nearer).within, (std::array<std::uint64_t, 5>{0, 1, 1, 1, 1}));
}

TEST(TapVid, BeginsAfterTheFirstVisibleFrame) {
  // Frame 0 is before the query, frame 1 the query itself.
  const Clip clip = clip_of(256, 256, {{ghost(), seen(100), seen(0), quiet(), unlabelled()}});
  const JaccardSums sums = all(clip);
  EXPECT_EQ(sums.evaluated, 2u);
  EXPECT_EQ(sums.agreed, 2u);
  EXPECT_EQ(sums.visible, 1u);
}

TEST(TapVid, AFeatureThatIsNeverVisibleDoesNotCount) {
  EXPECT_EQ(all(clip_of(256, 256, {{ghost(), ghost()}})).evaluated, 0u);
}

TEST(TapVid, AllScoresAreAsComputedByHand) {
  // After the query frame: visible and claimed 0.5 off; visible and claimed 3 off; visible, not claimed, last
  // report 1.5 off; hidden and claimed; hidden and not.
  const Clip clip = clip_of(256, 256, {{seen(0), seen(.5), seen(3), missed(1.5), ghost(), quiet()}});
  const JaccardScore score = jaccard_score(all(clip));
  // Of 3 visible: within 1: 1, within 2: 2, within 4, 8, 16: 3.
  EXPECT_DOUBLE_EQ(score.delta_avg, (1. / 3 + 2. / 3 + 1 + 1 + 1) / 5);
  // TP 1 1 2 2 2. FP, the ghost and the claim 3 off where that isn't within: 2 2 1 1 1. TP / (3 + FP).
  EXPECT_DOUBLE_EQ(score.aj, (1. / 5 + 1. / 5 + 2. / 4 + 2. / 4 + 2. / 4) / 5);
  EXPECT_DOUBLE_EQ(score.oa, 3. / 5);
}

TEST(TapVid, NoReportIsInfinitelyFar) {
  Sample none;
  none.presence = Presence::visible;
  const JaccardScore score = jaccard_score(all(clip_of(256, 256, {{seen(0), none}})));
  EXPECT_EQ(score.delta_avg, 0);
  EXPECT_EQ(score.oa, 0);
}

TEST(TapVid, WithoutEvaluatedFramesItIsUnknown) {
  const JaccardScore score = jaccard_score(all(clip_of(256, 256, {{seen(0)}})));
  EXPECT_TRUE(std::isnan(score.delta_avg) && std::isnan(score.aj) && std::isnan(score.oa));
}

}  // namespace
}  // namespace csd::score
