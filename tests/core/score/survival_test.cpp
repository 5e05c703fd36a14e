// SPDX-License-Identifier: LGPL-2.1-or-later
#include "score/survival.h"

#include <gtest/gtest.h>

#include "score/samples.h"

namespace csd::score {
namespace {

TEST(Survival, EndsForGoodWhereAVisibleFeatureIsTooFarOff) {
  // 511×511: the scale is 255/510 = 1/2. So 100 px are 50 and alive; 100.1 px are not.
  const Clip clip = clip_of(511, 511, {{seen(0), seen(100), seen(100.1), seen(0), quiet()}});
  const auto sums = survival_sums(clip);
  EXPECT_EQ(sums[0].alive, 2u);
  EXPECT_EQ(sums[0].labelled, 5u);
}

TEST(Survival, HiddenFeaturesSurviveAndUnlabelledFramesDoNotCount) {
  const Sample far_while_hidden{Presence::hidden, true, true, 400, 0, 1};
  const Clip clip = clip_of(511, 511, {{seen(0), far_while_hidden, unlabelled(), seen(0)}});
  EXPECT_EQ(survival_sums(clip)[0].alive, 3u);
  EXPECT_EQ(survival_sums(clip)[0].labelled, 3u);
}

TEST(Survival, AnUnclaimedFeatureIsJudgedByItsLastReport) {
  const Clip clip = clip_of(511, 511, {{seen(0), missed(30), missed(130)}});
  EXPECT_EQ(survival_sums(clip)[0].alive, 2u);
}

TEST(Survival, EachAxisHasItsOwnScale) {
  // 1021×256: ¼ and 1.
  const Clip clip = clip_of(1021, 256, {{seen(190)}, {seen(0, 60)}});
  EXPECT_EQ(survival_sums(clip)[0].alive, 1u);
  EXPECT_EQ(survival_sums(clip)[1].alive, 0u);
}

}  // namespace
}  // namespace csd::score
