// SPDX-License-Identifier: LGPL-2.1-or-later
#include "csd/judgement.h"

#include <gtest/gtest.h>

#include "core/csd/scene.h"
#include "csd/memory.h"

namespace csd {
namespace {

const AffineState start{{160, 120}};

struct Judging : testing::Test {
  Scene scene;
  CsdFrame frame = scene.frame({});
  Memory memory{frame, start};

  /// Seen well at `off` from the start, by a patch that locates itself to a pixel.
  static PointAlignment seen(cv::Point2d off) {
    PointAlignment alignment;
    alignment.fine.usable = true;
    alignment.fine.state = {start.position + off};
    alignment.fine.zncc = alignment.zncc_coarse = 0.95;
    alignment.fine.inliers = alignment.fine.centre = 0.9;
    alignment.fine.unmasked = 1;
    alignment.fine.noise = 2;
    alignment.fine.information = cv::Matx22d::eye();
    return alignment;
  }
  /// Neighbours that expect the point where it began. A pixel of the frame is two px.
  static Expectation expect(double deviation, double spread) {
    auto map = Scene::neighbours({});
    map.spread = spread;
    return {map, start, deviation};
  }
  Judgement judged(cv::Point2d off, const Expectation &expected) const {
    return judge(frame, seen(off), memory, expected);
  }
};

TEST_F(Judging, TheGateIsAsWideAsTheUncertainties) {
  // 1 px + 2 · .5 px + .25 pixels / .5 = 2.5 px: 1.25 pixels of the frame.
  const auto expected = expect(0.5, 0.25);
  EXPECT_TRUE(judged({1.24, 0}, expected).reliable);
  EXPECT_NEAR(judged({1.24, 0}, expected).distance, 2.48, 1e-9);
  const auto out = judged({0, 1.26}, expected);
  EXPECT_TRUE(out.vetoed && !out.reliable && !out.own_motion) << "the anchor's self-similarity isn't known yet";
  EXPECT_TRUE(judged({0, 1.26}, expect(0.8, 0.25)).reliable);
  auto few = expected;
  few.map.support = 4;
  EXPECT_TRUE(judged({0, 1.26}, few).reliable) << "four are too few";
  EXPECT_TRUE(judged({0, 60}, {}).reliable) << "none are too few";
}

TEST_F(Judging, ADifferentShapeFromTheNeighboursIsNotItsOwn) {
  auto alignment = seen({});
  alignment.fine.state.shape = cv::Matx22d(1.2, 0, 0, 1.2);  // ‖E − 1‖ = .28
  EXPECT_FALSE(judge(frame, alignment, memory, expect(0.5, 0.25)).vetoed);
  alignment.fine.state.shape = cv::Matx22d(1.22, 0, 0, 1.22);  // .31
  EXPECT_TRUE(judge(frame, alignment, memory, expect(0.5, 0.25)).vetoed);
}

TEST_F(Judging, ADistinctivePatchNeedsNoNeighbours) {
  memory.measure_self_similarity(frame, start);
  const auto expected = expect(0.5, 0.25);
  const auto distinctive = judged({9, 0}, expected);
  EXPECT_TRUE(distinctive.reliable && !distinctive.vetoed && distinctive.own_motion);
  auto poor = seen({9, 0});
  poor.zncc_coarse = 0.75;
  EXPECT_FALSE(judge(frame, poor, memory, expected).own_motion) << "the coarser level misfits";
  auto masked = seen({9, 0});
  masked.fine.unmasked = 0.2;
  EXPECT_FALSE(judge(frame, masked, memory, expected).own_motion);
}

TEST_F(Judging, IsReliableOnlyWithAGoodFitInsideThePicture) {
  const auto reliable = [&](auto change) {
    auto alignment = seen({});
    change(alignment);
    return judge(frame, alignment, memory, {}).reliable;
  };
  EXPECT_TRUE(reliable([](PointAlignment &) {}));
  EXPECT_FALSE(reliable([](PointAlignment &a) { a.fine.usable = false; }));
  EXPECT_FALSE(reliable([](PointAlignment &a) { a.fine.zncc = 0.59; }));
  EXPECT_FALSE(reliable([](PointAlignment &a) { a.fine.inliers = 0.49; }));
  EXPECT_FALSE(reliable([](PointAlignment &a) { a.fine.unmasked = 0.29; }));
  EXPECT_FALSE(reliable([](PointAlignment &a) { a.fine.state.position = {-1, 120}; }));
}

TEST_F(Judging, WeighsPatchAndNeighboursByInformation) {
  // Neighbours: sd (.2 + .3 · 1)·.5 + .2 · 1.25 = .5 pixels. The patch: information 4 across its edge, 0 along it.
  auto alignment = seen({1, 1});
  alignment.fine.information = cv::Matx22d(4, 0, 0, 0);
  const auto at = fuse(frame, alignment, expect(1, 1.25)) - start.position;
  EXPECT_NEAR(at.x, 0.5, 1e-3) << "4 against 4";
  EXPECT_NEAR(at.y, 0, 1e-3) << "the patch has no information in this direction";
}

TEST_F(Judging, GathersEvidenceOnlyWhereThePointCanBe) {
  const auto expected = expect(0.5, 0.25);
  const auto alignment = seen({1, 0});
  const auto judgement = judge(frame, alignment, memory, expected);
  const auto evidence = evidence_for(frame, alignment, memory, expected, judgement, {});
  ASSERT_TRUE(evidence);
  EXPECT_EQ(evidence->zncc_fine, 0.95);
  EXPECT_NEAR(evidence->disagreement, 2 / 1.5, 1e-9) << "px, over 1 + its deviation; no look-alike is known";
  const auto off = seen({9, 0});
  EXPECT_FALSE(evidence_for(frame, off, memory, expected, judge(frame, off, memory, expected), {})) << "vetoed";
  EXPECT_FALSE(evidence_for(frame, alignment, memory, {}, judgement, {})) << "nothing expects it anywhere";
  Surroundings alone;
  alone.alone = true;
  EXPECT_TRUE(evidence_for(frame, alignment, memory, {}, judgement, alone)) << "without neighbours to compare with";
}

}  // namespace
}  // namespace csd
