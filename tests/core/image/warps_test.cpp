// SPDX-License-Identifier: LGPL-2.1-or-later
#include "image/warps.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace csd {
namespace {

cv::Point2d map(const Warp &h, double u, double v) {
  const cv::Vec3d p = h * cv::Vec3d(u, v, 1);
  return {p[0] / p[2], p[1] / p[2]};
}

TEST(Warps, ZeroIsTheIdentityAndAllKeepTheCentre) {
  const auto warps = geometric_warps(21);
  ASSERT_EQ(warps.size(), 46u + 12u + 8u);
  for (const Warp &h : warps) {
    EXPECT_EQ(map(h, 0, 0), cv::Point2d(0, 0));
    EXPECT_GT(cv::norm(map(h, 10, 10) - cv::Point2d(10, 10)), 0.1);
  }
}

TEST(Warps, RotatesByUpTo45Degrees) {
  const double half = std::sqrt(0.5);
  EXPECT_NEAR(map(geometric_warps(21)[0], 1, 0).y, -half, 1e-12);  // −45°
  EXPECT_NEAR(map(geometric_warps(21)[45], 1, 0).y, half, 1e-12);
  EXPECT_NEAR(map(geometric_warps(21)[23], 1, 0).y, std::sin(std::numbers::pi / 180), 1e-12);  // 1°
}

TEST(Warps, ScaleIsMagnification) {
  const auto warps = geometric_warps(21);
  EXPECT_NEAR(map(warps[46], 8, 0).x, 10, 1e-12);
  EXPECT_NEAR(map(warps[57], 9, 3).x, 3, 1e-9);
  for (int i = 46; i < 56; ++i)
    EXPECT_NEAR(warps[i](0, 0) / warps[i + 1](0, 0), warps[i + 1](0, 0) / warps[i + 2](0, 0), 1e-9);
}

TEST(Warps, TiltIsThePinholeProjectionOfATurnedPlane) {
  const double d = camera_distance * 21;
  for (const double degrees : tilts) {
    const double a = degrees * std::numbers::pi / 180;
    for (const double p : {-9.0, 4.0})
      for (const double q : {-7.0, 10.0}) {
        // The point (p, q) of the plane, turned about the vertical axis, and its place in the camera's picture.
        const double depth = d + p * std::sin(a), u = d * p * std::cos(a) / depth, v = d * q / depth;
        EXPECT_NEAR(map(tilt_warp(degrees, 1, 21), u, v).x, p, 1e-9);
        EXPECT_NEAR(map(tilt_warp(degrees, 1, 21), u, v).y, q, 1e-9);
        EXPECT_NEAR(map(tilt_warp(degrees, 0, 21), v, u).x, q, 1e-9);
        EXPECT_NEAR(map(tilt_warp(degrees, 0, 21), v, u).y, p, 1e-9);
      }
  }
}

}  // namespace
}  // namespace csd
