// SPDX-License-Identifier: LGPL-2.1-or-later
#include "score/stir.h"

#include <gtest/gtest.h>

#include "score/samples.h"

namespace csd::score {
namespace {

TEST(Stir2026, UsesNativePixelsWithoutTheFirstFrame) {
  // 2 px off is not below 2, at any picture size. Frame 0 does not count, hidden or not.
  const Clip clip =
      clip_of(1280, 1024, {{seen(40), seen(2)}, {ghost(), seen(1.9)}, {quiet(), ghost()}, {seen(0), missed(5)}});
  const JaccardSums sums = stir_2026_sums(clip);
  EXPECT_EQ(sums.evaluated, 4u);
  EXPECT_EQ(sums.visible, 3u);
  EXPECT_EQ(sums.within, (std::array<std::uint64_t, 5>{1, 2, 3, 3, 3}));
  const JaccardScore score = jaccard_score(sums);
  // TP 1 2 2 2 2; FP: the ghost, and the 2 px one at 2: 2 1 1 1 1.
  EXPECT_DOUBLE_EQ(score.aj, (1. / 5 + 4 * 2. / 4) / 5);
  EXPECT_DOUBLE_EQ(score.delta_avg, (1. / 3 + 2. / 3 + 3) / 5);
  EXPECT_DOUBLE_EQ(score.oa, 2. / 4);
}

TEST(Stir2024, TakesTheNearestEndPointOfAny) {
  Clip clip;
  clip.ends = {{100, 100}, {200, 100}};
  // The first point went to the second's end, exactly 4 px beside it; the second to 30 px from the first's; the third
  // has no report.
  const std::vector<cv::Point2d> reports{{200, 104}, {70, 100}, {std::numeric_limits<double>::infinity(), 0}};
  const auto distances = end_distances(clip, reports);
  ASSERT_EQ(distances.size(), 3u);
  EXPECT_EQ(distances[0], 4);
  EXPECT_EQ(distances[1], 30);
  EXPECT_TRUE(std::isinf(distances[2]));
  const Stir2024Score score = stir_2024_score(distances);
  EXPECT_EQ(score.within, (Thresholds{1. / 3, 1. / 3, 1. / 3, 2. / 3, 2. / 3})) << "4 px is within 4";
  EXPECT_DOUBLE_EQ(score.delta_avg, (3 * 1. / 3 + 2 * 2. / 3) / 5);
}

TEST(Stir2024, WithoutEndPointsNothingIsKnown) {
  const std::vector<cv::Point2d> reports{{1, 1}};
  EXPECT_TRUE(end_distances(Clip(), reports).empty());
  EXPECT_TRUE(std::isnan(stir_2024_score({}).delta_avg));
}

}  // namespace
}  // namespace csd::score
