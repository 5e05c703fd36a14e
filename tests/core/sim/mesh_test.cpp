// SPDX-License-Identifier: LGPL-2.1-or-later
#include "sim/mesh.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "sim/tissue.h"

namespace csd::sim {
namespace {

Effects all_geometry(double strength) {
  Effects e;
  for (const Effect x : {Effect::heart_strong, Effect::heart_mild, Effect::liver, Effect::fold, Effect::zoom,
                         Effect::rotation, Effect::sway, Effect::jerk})
    e[x] = strength;
  return e;
}

TEST(Mesh, CoversThePictureInAnyMotion) {
  for (const double strength : {0.5, 1.0, 1.5}) {
    for (const cv::Size size : {cv::Size(640, 480), {480, 640}, {854, 480}}) {
      cv::Mat grey(64, 64, CV_8UC4, cv::Scalar(9, 9, 9, 9));
      Tissue tissue(all_geometry(strength), 8, TextureMap(grey, 1));
      Fragments fragments;
      for (double t = 0; t < 20; t += 1.33) {
        tissue.find(t, size, 0, fragments);
        int bare = 0;
        for (int y = 0; y < size.height; ++y)
          for (int x = 0; x < size.width; ++x) bare += fragments.at(x, y)[Fragment::depth] >= Fragments::nothing;
        EXPECT_EQ(bare, 0) << "strength " << strength << ", " << size << ", " << t << " s";
      }
    }
  }
}

TEST(Mesh, CoversThePictureWhereTissueIsCutPulledOrHollow) {
  for (const char *effects : {"slide,heart-strong,sway", "slide=3,tear=3,rotation,jerk", "tear,fold,heart-mild,zoom",
                              "grasp=2,heart-strong", "cavity,sway,jerk", "cavity=3,zoom,rotation", "cavity,sway,black",
                              "cavity,slide,tear,grasp,heart-mild,liver,sway"}) {
    Effects e;
    e.set(effects);
    const cv::Size size(320, 240);
    cv::Mat grey(64, 64, CV_8UC4, cv::Scalar(9, 9, 9, 9));
    Tissue tissue(e, 8, TextureMap(grey, 1));
    Fragments fragments;
    for (double t = 0; t < 20; t += 0.93) {
      tissue.find(t, size, 0, fragments);
      int bare = 0;
      for (int y = 0; y < size.height; ++y)
        for (int x = 0; x < size.width; ++x) bare += fragments.at(x, y)[Fragment::depth] >= Fragments::nothing;
      EXPECT_EQ(bare, 0) << effects << ", " << t << " s";
    }
  }
}

TEST(Mesh, CellsAreSmallHoweverNearTheScopeIs) {
  Effects e;
  e.set("zoom,rotation");
  const Surface surface(e, 1);
  Mesh mesh;
  for (const double t : {0.0, 7.5, 16.0}) {
    mesh.build(surface, surface.at(t), camera_at(t, e, 1, {640, 480}), {640, 480});
    double widest = 0;
    for (int j = 0; j < mesh.rows; ++j)
      for (int i = 0; i + 1 < mesh.columns; ++i) {
        const auto at = static_cast<std::size_t>(j * mesh.columns + i);
        const cv::Point3d d = mesh.points[at + 1].image - mesh.points[at].image;
        widest = std::max(widest, std::hypot(d.x, d.y));
      }
    EXPECT_LT(widest, 2 * Mesh::cell) << t;
    EXPECT_GT(widest, 0.8 * Mesh::cell) << t;
  }
}

TEST(Mesh, KnowsItsScaleAndItsNormals) {
  Effects e;
  const Surface surface(e, 1);
  Camera camera = camera_at(0, e, 1, {640, 480});
  Mesh mesh;
  mesh.build(surface, surface.at(0), camera, {640, 480});
  for (const auto &p : mesh.points) {
    EXPECT_NEAR(p.normal.dot(p.normal), 1, 1e-9);
    EXPECT_GT(p.normal.dot(p.place.normal), 0.995);
    // A unit is about a pixel, and more where the relief is near or seen at an angle.
    EXPECT_NEAR(p.units_log2, 0, 0.6);
  }
}

}  // namespace
}  // namespace csd::sim
