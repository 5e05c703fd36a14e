// SPDX-License-Identifier: LGPL-2.1-or-later
#include "score/recovery.h"

#include <gtest/gtest.h>

#include "score/samples.h"

namespace csd::score {
namespace {

TEST(Recovery, IsTheTimeFromTheReturnToTheFirstCorrectClaim) {
  // Visible again in frame 3. A claim 6 px off does not count; frame 5 is correct.
  const Clip clip = clip_of(640, 480, {{seen(0), quiet(), quiet(), missed(0), seen(6), seen(5)}});
  const auto found = recoveries(clip, 5);
  ASSERT_EQ(found.size(), 1u);
  EXPECT_TRUE(found[0].recovered);
  EXPECT_EQ(found[0].frames, 2u);
  EXPECT_EQ(found[0].time, 80000000);
}

TEST(Recovery, IsZeroIfClaimedAtOnce) {
  const auto found = recoveries(clip_of(640, 480, {{seen(0), quiet(Presence::out), seen(1)}}), 5);
  ASSERT_EQ(found.size(), 1u);
  EXPECT_TRUE(found[0].recovered);
  EXPECT_EQ(found[0].frames, 0u);
}

TEST(Recovery, EndsWithTheNextOcclusionOrNever) {
  const Clip clip = clip_of(640, 480, {{seen(0), quiet(), missed(0), quiet(), seen(1), quiet(), missed(0), missed(0)}});
  const auto found = recoveries(clip, 5);
  ASSERT_EQ(found.size(), 3u);
  EXPECT_FALSE(found[0].recovered);
  EXPECT_TRUE(found[1].recovered);
  EXPECT_FALSE(found[2].recovered);
}

TEST(Recovery, AFeatureNeverSeenBeforeDoesNotReturn) {
  EXPECT_TRUE(recoveries(clip_of(640, 480, {{quiet(), quiet(), seen(0), seen(0)}}), 5).empty());
}

TEST(Recovery, UnlabelledFramesNeitherHideNorShow) {
  EXPECT_TRUE(recoveries(clip_of(640, 480, {{seen(0), unlabelled(), seen(0)}}), 5).empty());
  const auto found = recoveries(clip_of(640, 480, {{seen(0), quiet(), unlabelled(), seen(0)}}), 5);
  ASSERT_EQ(found.size(), 1u);
  EXPECT_EQ(found[0].frames, 0u);
}

TEST(Recovery, WithoutPtsTheTimeIsUnknown) {
  Clip clip = clip_of(640, 480, {{seen(0), quiet(), seen(0)}});
  for (Moment &moment : clip.moments) moment.pts = no_time;
  EXPECT_EQ(recoveries(clip, 5).at(0).time, no_time);
}

}  // namespace
}  // namespace csd::score
