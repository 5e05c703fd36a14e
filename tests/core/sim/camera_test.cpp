// SPDX-License-Identifier: LGPL-2.1-or-later
#include "sim/camera.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "sim/events.h"

namespace csd::sim {
namespace {

const cv::Size vga{640, 480};

Effects moving() {
  Effects e;
  e.set("zoom,rotation,sway,jerk,black");
  return e;
}

TEST(Camera, ProjectsLikeAPinhole) {
  // By hand: 100 units ahead, 10 to the right, 5 down, focal length 600.
  Camera c;
  c.centre = {1, 2, 3};
  c.right = {1, 0, 0};
  c.down = {0, 1, 0};
  c.forward = {0, 0, -1};
  c.focal = 600;
  c.principal = {319.5, 239.5};
  const cv::Point3d p = c.project({11, 7, -97});
  EXPECT_DOUBLE_EQ(p.x, 319.5 + 60);
  EXPECT_DOUBLE_EQ(p.y, 239.5 + 30);
  EXPECT_DOUBLE_EQ(p.z, 100);
}

TEST(Camera, APixelsRayMeetsThePlaneWhereItIsSeen) {
  for (double t = 0; t < 25; t += 0.73) {
    const Camera c = camera_at(t, moving(), 5, vga);
    for (const cv::Point2d pixel : {cv::Point2d(0, 0), {639, 0}, {0, 479}, {639, 479}, {100.25, 300.75}}) {
      const cv::Point2d uv = c.to_plane(pixel);
      const cv::Point3d back = c.project({uv.x, uv.y, 0});
      EXPECT_NEAR(back.x, pixel.x, 1e-8);
      EXPECT_NEAR(back.y, pixel.y, 1e-8);
    }
  }
}

TEST(Camera, ItsAxesArePerpendicular) {
  for (double t = 0; t < 25; t += 0.9) {
    const Camera c = camera_at(t, moving(), 5, vga);
    EXPECT_NEAR(c.right.dot(c.right), 1, 1e-9);
    EXPECT_NEAR(c.right.dot(c.down), 0, 1e-9);
    EXPECT_NEAR(cv::norm(c.right.cross(c.down) + c.forward), 0, 1e-9);  // z points at the scope: not mirrored
    EXPECT_LT(c.forward[2], -0.8);                                      // down towards the tissue
  }
}

TEST(Camera, ZoomsAndRollsAsFarAsInThePapersSequences) {
  double least = 9, most = 0, left = 0, right = 0;
  for (double t = 0; t < cycle_seconds; t += 0.02) {
    least = std::min(least, zoom_at(t, 1));
    most = std::max(most, zoom_at(t, 1));
    left = std::min(left, 360 * roll_at(t, 1));
    right = std::max(right, 360 * roll_at(t, 1));
  }
  EXPECT_NEAR(least, 0.66, 1e-6);
  EXPECT_NEAR(most, 2.8, 1e-6);
  EXPECT_NEAR(left, -50, 1e-6);
  EXPECT_NEAR(right, 120, 1e-6);
  EXPECT_EQ(zoom_at(0, 1), 1);
  EXPECT_EQ(roll_at(0, 1), 0);
  EXPECT_EQ(zoom_at(7, 0), 1);
}

TEST(Camera, SeesAUnitAsAPixelAtVga) {
  const Camera c = camera_at(3, Effects(), 1, vga);
  EXPECT_DOUBLE_EQ(c.magnification, 1);
  EXPECT_DOUBLE_EQ(camera_at(3, Effects(), 1, {1280, 960}).magnification, 2);
  const cv::Point3d middle = c.project({0, 0, 0});
  EXPECT_NEAR(middle.x, 319.5, 1e-9);
  EXPECT_NEAR(middle.y, 239.5, 1e-9);
}

TEST(Camera, MovesForwardsAndBackwardsInACavity) {
  Effects e;
  e.set("cavity");
  double nearest = 1e9, farthest = 0;
  for (double t = 0; t < 20; t += 0.1) {
    nearest = std::min(nearest, camera_at(t, e, 1, vga).distance);
    farthest = std::max(farthest, camera_at(t, e, 1, vga).distance);
  }
  EXPECT_NEAR(nearest, 600 / 1.24, 3);
  EXPECT_NEAR(farthest, 600 / 0.76, 3);
  EXPECT_LT(cv::norm(camera_at(0.04, e, 1, vga).centre - camera_at(0, e, 1, vga).centre), 0.1);  // from rest
}

TEST(Camera, JumpsOnlyWithJerk) {
  Effects sway, jerk;
  sway.set("sway");
  jerk.set("jerk");
  const auto fastest = [](const Effects &e) {
    double most = 0;
    for (double t = 0; t < 40; t += 0.04) {
      const cv::Vec3d d = camera_at(t + 0.04, e, 2, vga).centre - camera_at(t, e, 2, vga).centre;
      most = std::max(most, std::sqrt(d.dot(d)));
    }
    return most;
  };
  EXPECT_LT(fastest(sway), 8);
  EXPECT_GT(fastest(jerk), 15);
  EXPECT_EQ(fastest(Effects()), 0);
}

}  // namespace
}  // namespace csd::sim
