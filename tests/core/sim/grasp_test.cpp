// SPDX-License-Identifier: LGPL-2.1-or-later
#include "sim/grasp.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

namespace csd::sim {
namespace {

double pulled(double time, double strength = 1) {
  return cv::norm(grasp_at(time, strength, 3).pull);
}

TEST(Grasp, TissueIsAtRestBeforeAGraspAndWithoutOne) {
  for (double t = 0; t < 0.7; t += 0.02) EXPECT_EQ(pulled(t), 0) << t;
  for (double t = 0; t < 20; t += 0.3) {
    EXPECT_EQ(pulled(t, 0), 0);
    EXPECT_EQ(grasp_at(t, 0, 3).in, 0);
  }
  EXPECT_EQ(grasp_at(0, 1, 3).in, 0);  // features are chosen at this time
  EXPECT_EQ(grasp_at(0.65, 1, 3).in, 1);
  EXPECT_EQ(grasp_at(0.65, 1, 3).open, 0);
}

TEST(Grasp, EachGraspPullsAnotherPlaceNearTheMiddleToItsStatedDepth) {
  cv::Point2d last(1e9, 1e9);
  for (int i = 0; i < 12; ++i) {
    const Grasp g = grasp_at(5 * i + 3, 1, 3);
    EXPECT_LE(std::abs(g.hold.x), 120);
    EXPECT_LE(std::abs(g.hold.y), 85);
    EXPECT_GT(cv::norm(g.hold - last), 1);
    last = g.hold;
    const double sideways = std::hypot(g.pull[0], g.pull[1]);
    EXPECT_GT(sideways, 28 * 0.99);
    EXPECT_LE(sideways, grasp_reach(1) + 1e-9);
    EXPECT_EQ(grasp_at(5 * i + 3, 1, 3).at(g.hold.x, g.hold.y), g.pull);
  }
}

TEST(Grasp, PullsInStepsAndSpringsBackAtOnce) {
  std::vector<double> steps;
  for (double t = 0.7; t < 2.66; t += 0.04) steps.push_back(pulled(t + 0.04) - pulled(t));
  std::sort(steps.begin(), steps.end());
  EXPECT_GE(steps.front(), 0);
  EXPECT_GT(steps.back(), 4 * steps[steps.size() / 2]);
  EXPECT_GT(pulled(3.5), 25);
  EXPECT_LT(pulled(3.7), 0.2 * pulled(3.5));
  EXPECT_LT(pulled(4.49), 0.01);
}

TEST(Grasp, FallsOffLikeACuspAndFoldsNothing) {
  for (const double strength : {0.5, 1.0, 2.0, 4.0}) {
    const Grasp g = grasp_at(3, strength, 3);
    const cv::Vec2d d = cv::Vec2d(g.pull[0], g.pull[1]) / std::hypot(g.pull[0], g.pull[1]);
    const auto moved = [&](double r) {  // in the direction of the pull
      const cv::Vec3d by = g.at(g.hold.x + r * d[0], g.hold.y + r * d[1]);
      return by[0] * d[0] + by[1] * d[1];
    };
    for (double r = -300; r < 300; r += 0.5) EXPECT_GT(r + 0.5 + moved(r + 0.5), r + moved(r)) << strength << ' ' << r;
    EXPECT_NEAR(moved(100 + g.sigma) / moved(100), std::exp(-1), 0.01);
    // A Gaussian of this width would keep nine tenths.
    EXPECT_LT(moved(0.5 * g.sigma), 0.7 * moved(0));
  }
}

}  // namespace
}  // namespace csd::sim
