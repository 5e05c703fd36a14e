// SPDX-License-Identifier: LGPL-2.1-or-later
#include "sim/cavity.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "sim/camera.h"

namespace csd::sim {
namespace {

double depth(const cv::Vec3d &p) {
  return nominal_distance - p[2];
}

TEST(Cavity, WithoutStrengthItIsAPlane) {
  EXPECT_FALSE(Cavity(0).any());
  EXPECT_EQ(Cavity(0).reach(), 0);
  for (double u = -300; u <= 300; u += 77) EXPECT_EQ(Cavity(0).at(u, 50, 12), cv::Vec3d(u, 50, 12));
  const cv::Vec3d nearly = Cavity(1e-6).at(200, -100, 7);
  EXPECT_NEAR(cv::norm(nearly - cv::Vec3d(200, -100, 7)), 0, 1e-2);
}

TEST(Cavity, ItsEndIsThreeTimesAsFarAsItsWallsInThePicture) {
  const Cavity c(1);
  double nearest = 1e9, farthest = 0;
  for (double v = -240; v <= 240; v += 10)
    for (double u = -320; u <= 320; u += 10) {
      nearest = std::min(nearest, depth(c.at(u, v, 0)));
      farthest = std::max(farthest, depth(c.at(u, v, 0)));
    }
  EXPECT_GT(farthest, 3 * nearest);
  EXPECT_GT(nearest, 300);  // leaves the scope room to move
  EXPECT_EQ(depth(c.at(0, 0, 0)), farthest);
}

TEST(Cavity, RingsRiseFromTheWallAndHideWhatIsBehind) {
  const Cavity c(1);
  int hidden = 0, rays = 0;
  for (double turn = 0; turn < 2 * CV_PI; turn += 0.1, ++rays) {
    double last = 0;
    bool back = false;
    for (double r = 40; r < 400; r += 2) {
      const cv::Vec3d p = c.at(r * std::cos(turn), r * std::sin(turn), 0);
      const double seen = nominal_distance * std::hypot(p[0], p[1]) / depth(p);  // off the axis, in the picture
      EXPECT_GT(seen, 0.5 * r);
      EXPECT_LE(seen, r + 1e-9);
      back |= seen < last;
      last = seen;
    }
    hidden += back;
  }
  EXPECT_GT(hidden, rays / 3);
}

TEST(Cavity, DeeperWallsAreSeenAtASmallerAngle) {
  const Cavity c(1);
  EXPECT_NEAR(Cavity(1e-9).facing(0, 0), 1, 1e-3);
  EXPECT_GT(c.facing(300, 0), c.facing(100, 0));
  for (double u = 20; u <= 400; u += 20) {
    EXPECT_GT(c.facing(u, 30), 0.1);
    EXPECT_LE(c.facing(u, 30), 1);
  }
}

TEST(Cavity, PointsStayWithinTheStatedDistanceOfTheirPlace) {
  for (const double strength : {0.3, 1.0, 2.0, 4.0}) {
    const Cavity c(strength);
    for (double v = -320; v <= 320; v += 16)
      for (double u = -400; u <= 400; u += 16) {
        const cv::Vec3d p = c.at(u, v, -30);
        EXPECT_LE(std::hypot(p[0] - u, p[1] - v), c.reach()) << strength << ' ' << u << ' ' << v;
        EXPECT_GT(depth(p), 40);
      }
  }
}

}  // namespace
}  // namespace csd::sim
