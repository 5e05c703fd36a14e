// SPDX-License-Identifier: LGPL-2.1-or-later
#include "sim/surface.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

namespace csd::sim {
namespace {

Effects only(const std::string &text) {
  Effects e;
  e.set(text);
  return e;
}

TEST(Surface, LiesStillWithoutEffects) {
  const Surface s(Effects(), 1);
  const auto place = s.place(30, -70);
  for (const double t : {0.0, 0.3, 17.0}) EXPECT_EQ(s.at(t).at(place), cv::Vec3d(30, -70, place.rest[2]));
}

TEST(Surface, TheNormalIsThatOfTheShapeAtRest) {
  for (const char *effects : {"", "fold"}) {
    // The fold breathes about its shape at rest; without breath and heart it hardly moves.
    const Surface s(only(effects), 4);
    for (double u = -300; u <= 300; u += 60) {
      for (double v = -220; v <= 220; v += 55) {
        const auto rest = [&](double x, double y) {
          const auto p = s.place(x, y);
          return cv::Vec3d(x, y, p.rest[2]) + p.fold * cv::Vec3d(0, 135, 85) * (effects[0] != 0 ? 1 : 0);
        };
        const cv::Vec3d du = rest(u + 0.1, v) - rest(u - 0.1, v), dv = rest(u, v + 0.1) - rest(u, v - 0.1);
        const cv::Vec3d n = du.cross(dv);
        EXPECT_NEAR(cv::norm(n / cv::norm(n) - s.place(u, v).normal), 0, 2e-3) << effects << " " << u << " " << v;
      }
    }
  }
}

/// The share of a point's motion energy near a frequency (Hz), by a Fourier sum over 80 s.
double share_at(const Surface &s, double frequency) {
  const auto place = s.place(-60, 40);
  std::vector<cv::Vec3d> path;
  cv::Vec3d mean(0, 0, 0);
  constexpr int n = 2000;
  for (int i = 0; i < n; ++i) {
    path.push_back(s.at(i * 0.04).at(place));
    mean += path.back() / n;
  }
  double all = 0, near = 0;
  for (const auto &p : path) all += (p - mean).dot(p - mean);
  for (double f = frequency * 0.88; f <= frequency * 1.12; f += 1.0 / 80) {
    for (int axis = 0; axis < 3; ++axis) {
      double re = 0, im = 0;
      for (int i = 0; i < n; ++i) {
        re += (path[static_cast<std::size_t>(i)][axis] - mean[axis]) * std::cos(2 * M_PI * f * i * 0.04);
        im += (path[static_cast<std::size_t>(i)][axis] - mean[axis]) * std::sin(2 * M_PI * f * i * 0.04);
      }
      near += 2 * (re * re + im * im) / n;
    }
  }
  return near / all;
}

TEST(Surface, BeatsAndBreathes) {
  EXPECT_GT(share_at(Surface(only("heart-strong"), 2), 1.25), 0.5);
  EXPECT_LT(share_at(Surface(only("heart-strong"), 2), 0.25), 0.3);
  EXPECT_GT(share_at(Surface(only("liver"), 2), 0.25), 0.6);
  EXPECT_LT(share_at(Surface(only("liver"), 2), 1.25), 0.1);
}

TEST(Surface, MovesAsFarAsStated) {
  for (const char *effects : {"heart-strong", "heart-mild", "liver", "fold", "heart-strong,liver,fold"}) {
    for (const std::uint64_t seed : {1U, 2U, 3U}) {
      const Surface s(only(effects), seed);
      double farthest = 0;
      for (double t = 0; t < 12; t += 0.17) {
        const auto moment = s.at(t);
        for (double u = -320; u <= 320; u += 40)
          for (double v = -240; v <= 240; v += 40) {
            const cv::Vec3d p = moment.at(s.place(u, v));
            farthest = std::max(farthest, std::sqrt((p[0] - u) * (p[0] - u) + (p[1] - v) * (p[1] - v)));
          }
      }
      EXPECT_LE(farthest, s.reach()) << effects;
      EXPECT_GT(farthest, 3) << effects;
    }
  }
}

TEST(Surface, StrongIsStrongerThanMild) {
  const auto travel = [](const char *effects) {
    const Surface s(only(effects), 6);
    double sum = 0;
    for (double u = -200; u <= 200; u += 50)
      for (double t = 0; t < 4; t += 0.04)
        sum += cv::norm(s.at(t + 0.04).at(s.place(u, 0)) - s.at(t).at(s.place(u, 0)));
    return sum;
  };
  EXPECT_GT(travel("heart-strong"), 2 * travel("heart-mild"));
  EXPECT_GT(travel("heart-mild=2"), 1.8 * travel("heart-mild"));
}

}  // namespace
}  // namespace csd::sim
