// SPDX-License-Identifier: LGPL-2.1-or-later
#include "score/calibration.h"

#include <gtest/gtest.h>

#include "score/samples.h"

namespace csd::score {
namespace {

Sample sure(double confidence, const Sample &sample) {
  Sample with = sample;
  with.confidence = confidence;
  return with;
}

TEST(Reliability, IsAsComputedByHand) {
  // Bin 9: .9 true, .96 true, 1 false (6 px off). Bin 3: .3 true, .34 false (hidden). Bin 0: 0 true (near, not
  // claimed).
  const Clip clip = clip_of(640, 480,
                            {{sure(.9, seen(1))},
                             {sure(.96, seen(5))},
                             {sure(1, seen(6))},
                             {sure(.3, seen(0))},
                             {sure(.34, ghost())},
                             {sure(0, missed(0))}});
  Reliability reliability;
  reliability.add(clip, 5);
  EXPECT_EQ(reliability.bins[9].reports, 3u);
  EXPECT_DOUBLE_EQ(reliability.bins[9].frequency(), 2. / 3);
  EXPECT_DOUBLE_EQ(reliability.bins[9].mean_confidence(), 2.86 / 3);
  EXPECT_EQ(reliability.bins[3].reports, 2u);
  EXPECT_DOUBLE_EQ(reliability.bins[3].frequency(), .5);
  EXPECT_EQ(reliability.bins[0].reports, 1u);
  EXPECT_TRUE(std::isnan(reliability.bins[5].frequency()));
  // (3·|.9533 − .6667| + 2·|.32 − .5| + 1·|0 − 1|) / 6
  EXPECT_NEAR(reliability.ece(), (.86 + .36 + 1) / 6, 1e-12);
}

TEST(Reliability, OnlyReportsOnLabelledFramesCount) {
  Sample gone = missed(0);
  gone.reported = false;
  Reliability reliability;
  reliability.add(clip_of(640, 480, {{gone, unlabelled()}}), 5);
  EXPECT_TRUE(std::isnan(reliability.ece()));
}

}  // namespace
}  // namespace csd::score
