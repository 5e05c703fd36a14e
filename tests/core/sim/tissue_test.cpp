// SPDX-License-Identifier: LGPL-2.1-or-later
#include "sim/tissue.h"

#include <gtest/gtest.h>

#include <cmath>

#include "dots.h"

namespace csd::sim {
namespace {

const cv::Size size{320, 240};

Effects only(const std::string &text) {
  Effects e;
  e.set(text);
  return e;
}

Tissue tissue_of(const Effects &effects) {
  const Dots dots;
  return Tissue(effects, 5, std::move(texture_of_picture(dots.texture, 600, 1.6, 200, 1).map));
}

TEST(Tissue, FragmentsAreWhereTheirPointsAre) {
  Tissue tissue = tissue_of(only("heart-strong,zoom,rotation"));
  Fragments f;
  for (const double t : {0.0, 2.2, 6.4}) {
    tissue.find(t, size, 0, f);
    double squares = 0;
    int n = 0;
    for (int y = 0; y < size.height; y += 7)
      for (int x = 0; x < size.width; x += 7, ++n) {
        const cv::Point3d p = tissue.project(t, size, {f.at(x, y)[Fragment::u], f.at(x, y)[Fragment::v]});
        squares += (p.x - x) * (p.x - x) + (p.y - y) * (p.y - y);
        EXPECT_NEAR(p.z, f.at(x, y)[Fragment::depth], 0.2);
      }
    EXPECT_LT(std::sqrt(squares / n), 0.03) << t;
  }
}

TEST(Tissue, FragmentsOfCutPulledAndHollowTissueAreWhereTheirPointsAre) {
  for (const char *effects : {"slide", "tear", "grasp", "cavity", "slide,tear,grasp,heart-strong"}) {
    Tissue tissue = tissue_of(only(effects));
    Fragments f;
    for (const double t : {0.0, 2.2, 3.3, 6.4}) {
      tissue.find(t, {640, 480}, 0, f);
      double squares = 0;
      int n = 0;
      for (int y = 0; y < 480; y += 7)
        for (int x = 0; x < 640; x += 7) {
          if (f.at(x, y)[Fragment::sheet] < 0) continue;
          const cv::Point3d p = tissue.project(t, {640, 480}, {f.at(x, y)[Fragment::u], f.at(x, y)[Fragment::v]});
          squares += std::min((p.x - x) * (p.x - x) + (p.y - y) * (p.y - y), 4.0);  // at edges u and v jump
          ++n;
        }
      std::printf("%s %.1f: %.4f\n", effects, t, std::sqrt(squares / n));
      EXPECT_LT(std::sqrt(squares / n), 0.05) << effects << ' ' << t;
    }
  }
}

TEST(Tissue, KnowsHowFarThingsMoveDuringTheExposure) {
  Tissue tissue = tissue_of(only("heart-strong,sway,jerk"));
  Fragments f;
  const double t = 2.75, shutter = 0.02;
  tissue.find(t, size, shutter, f);
  double most = 0;
  for (int y = 3; y < size.height; y += 31)
    for (int x = 3; x < size.width; x += 31) {
      const cv::Point2d uv(f.at(x, y)[Fragment::u], f.at(x, y)[Fragment::v]);
      const cv::Point3d a = tissue.project(t - shutter / 2, size, uv), b = tissue.project(t + shutter / 2, size, uv);
      EXPECT_NEAR(f.at(x, y)[Fragment::motion_x], b.x - a.x, 0.03);
      EXPECT_NEAR(f.at(x, y)[Fragment::motion_y], b.y - a.y, 0.03);
      most = std::max(most, std::hypot(b.x - a.x, b.y - a.y));
    }
  EXPECT_GT(most, 0.3);
}

TEST(Tissue, IsHeldByTheGraspersTip) {
  const Tissue tissue = tissue_of(only("grasp,heart-strong,sway"));
  for (const double t : {0.7, 2.2, 3.4, 8.0}) {
    const auto grip = tissue.grip(t, size);
    ASSERT_TRUE(grip);
    const cv::Point3d at = tissue.project(t, size, grasp_at(t, 1, 5).hold);
    EXPECT_NEAR(grip->tip.x, at.x, 1e-9) << t;
    EXPECT_NEAR(grip->tip.y, at.y, 1e-9) << t;
  }
  EXPECT_FALSE(tissue.grip(0, size));
  EXPECT_FALSE(tissue_of(only("")).grip(2, size));
}

TEST(Tissue, EdgesOfAWoundAreSoft) {
  const cv::Mat grey(64, 64, CV_8UC4, cv::Scalar(150, 150, 150, 0));
  Tissue tissue(only("tear"), 5, TextureMap(grey, 1));
  Fragments f;
  Canvas c;
  tissue.find(4, {640, 480}, 0, f);
  tissue.paint(4, f, c);
  int between = 0, edges = 0;
  for (int y = 1; y < 479; ++y)
    for (int x = 2; x < 637; ++x) {
      const auto bed = [&](int at) { return f.at(at, y)[Fragment::sheet] < 0; };
      if (bed(x - 2) || bed(x - 1) || !bed(x) || !bed(x + 1) || !bed(x + 2)) continue;
      ++edges;
      const float skin = c.row(1, y)[x - 2], wound = c.row(1, y)[x + 2];
      between += c.row(1, y)[x] > wound + 0.1F * (skin - wound) && c.row(1, y)[x - 1] < skin - 0.1F * (skin - wound);
    }
  EXPECT_GT(edges, 15);
  EXPECT_GT(between, 0.6 * edges);
}

TEST(BlurMotion, BlursAlongTheMotionWithoutAShift) {
  const cv::Size s{64, 64};
  Fragments f;
  f.reset(s);
  std::vector<cv::Point2d> image{{-10, -10}, {80, -10}, {-10, 80}, {80, 80}};
  std::vector<Fragment> corners(4);
  for (auto &c : corners) {
    c[Fragment::depth] = 1;
    c[Fragment::motion_x] = 9;
    c[Fragment::motion_y] = -3;
  }
  f.draw_grid(2, 2, image, corners, Fragment::count);
  Canvas c, copy;
  c.resize(s);
  for (std::size_t k = 0; k < 3; ++k)
    for (int y = 0; y < 64; ++y)
      for (int x = 0; x < 64; ++x)
        c.row(k, y)[x] = static_cast<float>(100 * std::exp(-((x - 30.0) * (x - 30) + (y - 33.0) * (y - 33)) / 8));
  blur_motion(f, c, copy);
  double sum = 0, mx = 0, my = 0, xx = 0, yy = 0, xy = 0;
  for (int y = 0; y < 64; ++y)
    for (int x = 0; x < 64; ++x) {
      const double v = c.row(1, y)[x];
      sum += v;
      mx += v * x;
      my += v * y;
      xx += v * (x - 30) * (x - 30);
      yy += v * (y - 33) * (y - 33);
      xy += v * (x - 30) * (y - 33);
    }
  EXPECT_NEAR(mx / sum, 30, 1e-3);
  EXPECT_NEAR(my / sum, 33, 1e-3);
  // A line of 9 adds 81/12 to the blob's own variance of 4.
  EXPECT_NEAR(xx / sum, 4 + 81.0 / 12, 1.2);
  EXPECT_NEAR(yy / sum, 4 + 9.0 / 12, 0.4);
  EXPECT_LT(xy / sum, -1);
}

TEST(Tissue, WashedTissueLooksDifferentForGood) {
  // Without motion, before and long after, only the places of the fluids differ.
  const Effects effects = only("blood");
  Tissue tissue = tissue_of(effects);
  Fragments f;
  Canvas before, after;
  tissue.find(0, size, 0, f);
  tissue.paint(0, f, before);
  tissue.find(99, size, 0, f);
  tissue.paint(99, f, after);
  int changed = 0, same = 0;
  for (int y = 0; y < size.height; ++y)
    for (int x = 0; x < size.width; ++x) {
      const float difference = std::abs(after.row(1, y)[x] - before.row(1, y)[x]);
      changed += difference > 20;
      same += difference == 0;
    }
  EXPECT_GT(changed, 5000);
  EXPECT_GT(same, 20000);
  EXPECT_FALSE(tissue.drowned(99, {-100, 0}));
}

}  // namespace
}  // namespace csd::sim
