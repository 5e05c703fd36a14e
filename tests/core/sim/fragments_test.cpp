// SPDX-License-Identifier: LGPL-2.1-or-later
#include "sim/fragments.h"

#include <gtest/gtest.h>

#include <cmath>

namespace csd::sim {
namespace {

/// A grid over the picture with jittered corners. Values are linear in the picture's x and y.
struct Grid {
  int columns = 9, rows = 7;
  std::vector<cv::Point2d> image;
  std::vector<Fragment> corners;

  explicit Grid(float depth, cv::Point2d from = {-20, -20}, double cell = 24) {
    cv::RNG rng(5);
    for (int j = 0; j < rows; ++j)
      for (int i = 0; i < columns; ++i) {
        const cv::Point2d p(from.x + cell * i + rng.uniform(-5.0, 5.0), from.y + cell * j + rng.uniform(-5.0, 5.0));
        // As drawn, in 1/256 pixel.
        image.emplace_back(std::round(p.x * 256) / 256, std::round(p.y * 256) / 256);
        Fragment f;
        f[Fragment::depth] = depth;
        f[Fragment::u] = static_cast<float>(3 * image.back().x - 2 * image.back().y + 7);
        f[Fragment::motion_y] = static_cast<float>(-image.back().x + 4 * image.back().y);
        corners.push_back(f);
      }
  }
};

TEST(Fragments, InterpolateLinearlyWithoutCracks) {
  const Grid grid(100);
  Fragments f;
  f.reset({150, 100});
  f.draw_grid(grid.columns, grid.rows, grid.image, grid.corners, Fragment::count);
  for (int y = 0; y < 100; ++y)
    for (int x = 0; x < 150; ++x) {
      ASSERT_EQ(f.at(x, y)[Fragment::depth], 100) << x << "," << y;
      EXPECT_NEAR(f.at(x, y)[Fragment::u], 3 * x - 2 * y + 7, 2e-3);
      EXPECT_NEAR(f.at(x, y)[Fragment::motion_y], -x + 4 * y, 2e-3);
    }
}

TEST(Fragments, APartIsDrawnUpToItsBorderWithinTheCells) {
  const Grid grid(100);
  std::vector<std::uint8_t> owners;
  const auto left = [](float u, float) { return u < 217; };
  for (const Fragment &c : grid.corners) owners.push_back(left(c[Fragment::u], 0) ? 1 : 2);
  owners[0] = Part::nobody;
  Fragments f;
  f.reset({150, 100});
  const Part part{owners, 1, left};
  f.draw_grid(grid.columns, grid.rows, grid.image, grid.corners, Fragment::count, &part);
  int drawn = 0;
  for (int y = 20; y < 100; ++y)
    for (int x = 20; x < 150; ++x) {
      const bool there = f.at(x, y)[Fragment::depth] < Fragments::nothing;
      drawn += there;
      if (3 * x - 2 * y != 210) {
        EXPECT_EQ(there, 3 * x - 2 * y < 210) << x << "," << y;
      }
    }
  EXPECT_GT(drawn, 3000);
  EXPECT_EQ(f.at(0, 0)[Fragment::depth], Fragments::nothing);  // in the cell without any of the part's corners
}

TEST(Fragments, ShowTheNearest) {
  const Grid far(100), near(50, {60, -20}, 24);
  for (const bool near_first : {false, true}) {
    Fragments f;
    f.reset({150, 100});
    for (const Grid *g : {near_first ? &near : &far, near_first ? &far : &near})
      f.draw_grid(g->columns, g->rows, g->image, g->corners, 8);
    EXPECT_EQ(f.at(20, 50)[Fragment::depth], 100);
    EXPECT_EQ(f.at(120, 50)[Fragment::depth], 50);
  }
}

TEST(Fragments, EmptyPlacesStayEmpty) {
  const Grid grid(100, {70, 40}, 3);
  Fragments f;
  f.reset({150, 100});
  f.draw_grid(grid.columns, grid.rows, grid.image, grid.corners, 8);
  EXPECT_EQ(f.at(10, 10)[Fragment::depth], Fragments::nothing);
  EXPECT_EQ(f.at(82, 49)[Fragment::depth], 100);
  f.reset({150, 100});
  EXPECT_EQ(f.at(82, 49)[Fragment::depth], Fragments::nothing);
}

TEST(Fragments, ATriangleSeenFromBehindCountsToo) {
  // Two columns; the right one lies left of the left one.
  std::vector<cv::Point2d> image{{60, 10}, {20, 10}, {60, 50}, {20, 50}};
  std::vector<Fragment> corners(4);
  for (auto &c : corners) c[Fragment::depth] = 5;
  Fragments f;
  f.reset({80, 60});
  f.draw_grid(2, 2, image, corners, 8);
  EXPECT_EQ(f.at(40, 30)[Fragment::depth], 5);
}

}  // namespace
}  // namespace csd::sim
