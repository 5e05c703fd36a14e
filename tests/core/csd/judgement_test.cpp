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
  static Look seen(cv::Point2d off) {
    Look look;
    look.fine.usable = true;
    look.fine.state = {start.position + off};
    look.fine.zncc = look.zncc_coarse = 0.95;
    look.fine.inliers = look.fine.centre = 0.9;
    look.fine.unmasked = 1;
    look.fine.noise = 2;
    look.fine.information = cv::Matx22d::eye();
    return look;
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
  EXPECT_TRUE(judged({1.24, 0}, expected).sure);
  EXPECT_NEAR(judged({1.24, 0}, expected).distance, 2.48, 1e-9);
  const auto out = judged({0, 1.26}, expected);
  EXPECT_FALSE(out.sure || out.agrees || out.own_motion) << "the anchor's likeness isn't known yet";
  EXPECT_TRUE(judged({0, 1.26}, expect(0.8, 0.25)).sure);
  auto few = expected;
  few.map.support = 4;
  EXPECT_TRUE(judged({0, 1.26}, few).sure) << "four are too few";
  EXPECT_TRUE(judged({0, 60}, {}).sure) << "none are too few";
}

TEST_F(Judging, ADifferentShapeFromTheNeighboursIsNotItsOwn) {
  auto look = seen({});
  look.fine.state.shape = cv::Matx22d(1.2, 0, 0, 1.2);  // ‖E − 1‖ = .28
  EXPECT_TRUE(judge(frame, look, memory, expect(0.5, 0.25)).agrees);
  look.fine.state.shape = cv::Matx22d(1.22, 0, 0, 1.22);  // .31
  EXPECT_FALSE(judge(frame, look, memory, expect(0.5, 0.25)).agrees);
}

TEST_F(Judging, ADistinctivePatchNeedsNoNeighbours) {
  memory.measure_likeness(frame, start);
  const auto expected = expect(0.5, 0.25);
  const auto apart = judged({9, 0}, expected);
  EXPECT_TRUE(apart.sure && apart.agrees && apart.own_motion);
  auto poor = seen({9, 0});
  poor.zncc_coarse = 0.75;
  EXPECT_FALSE(judge(frame, poor, memory, expected).own_motion) << "the coarser level misfits";
  auto masked = seen({9, 0});
  masked.fine.unmasked = 0.2;
  EXPECT_FALSE(judge(frame, masked, memory, expected).own_motion);
}

TEST_F(Judging, IsSureOnlyOfAGoodFitInsideThePicture) {
  const auto sure = [&](auto change) {
    auto look = seen({});
    change(look);
    return judge(frame, look, memory, {}).sure;
  };
  EXPECT_TRUE(sure([](Look &) {}));
  EXPECT_FALSE(sure([](Look &l) { l.fine.usable = false; }));
  EXPECT_FALSE(sure([](Look &l) { l.fine.zncc = 0.59; }));
  EXPECT_FALSE(sure([](Look &l) { l.fine.inliers = 0.49; }));
  EXPECT_FALSE(sure([](Look &l) { l.fine.unmasked = 0.29; }));
  EXPECT_FALSE(sure([](Look &l) { l.fine.state.position = {-1, 120}; }));
}

TEST_F(Judging, WeighsPatchAndNeighboursByInformation) {
  // Neighbours: sd (.2 + .3 · 1)·.5 + .2 · 1.25 = .5 pixels. The patch: information 4 across its edge, 0 along it.
  auto look = seen({1, 1});
  look.fine.information = cv::Matx22d(4, 0, 0, 0);
  const auto at = fuse(frame, look, expect(1, 1.25)) - start.position;
  EXPECT_NEAR(at.x, 0.5, 1e-3) << "4 against 4";
  EXPECT_NEAR(at.y, 0, 1e-3) << "the patch has no information in this direction";
}

TEST_F(Judging, GathersEvidenceOnlyWhereThePointCanBe) {
  const auto expected = expect(0.5, 0.25);
  const auto look = seen({1, 0});
  const auto judgement = judge(frame, look, memory, expected);
  const auto evidence = evidence_for(frame, look, memory, expected, judgement, {});
  ASSERT_TRUE(evidence);
  EXPECT_EQ(evidence->zncc_fine, 0.95);
  EXPECT_NEAR(evidence->disagreement, 2 / 1.5, 1e-9) << "px, over 1 + its deviation; no look-alike is known";
  const auto off = seen({9, 0});
  EXPECT_FALSE(evidence_for(frame, off, memory, expected, judge(frame, off, memory, expected), {})) << "overruled";
  EXPECT_FALSE(evidence_for(frame, look, memory, {}, judgement, {})) << "nothing expects it anywhere";
  Surroundings alone;
  alone.alone = true;
  EXPECT_TRUE(evidence_for(frame, look, memory, {}, judgement, alone)) << "without neighbours to compare with";
}

}  // namespace
}  // namespace csd
