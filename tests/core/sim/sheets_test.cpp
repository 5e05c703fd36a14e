// SPDX-License-Identifier: LGPL-2.1-or-later
#include "sim/sheets.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

namespace csd::sim {
namespace {

Sheets sheets_of(const std::string &effects, std::uint64_t seed = 3) {
  Effects e;
  e.set(effects);
  return Sheets(e, seed);
}

std::vector<int> numbers(const Sheets &sheets) {
  std::vector<int> all;
  sheets.each([&](std::uint8_t s) { all.push_back(s); });
  return all;
}

double sideways(const cv::Vec3d &v) {
  return std::hypot(v[0], v[1]);
}

TEST(Sheets, TheEffectsSetTheirNumber) {
  EXPECT_FALSE(sheets_of("").any());
  EXPECT_EQ(numbers(sheets_of("")), std::vector<int>({0}));
  EXPECT_EQ(numbers(sheets_of("slide")), std::vector<int>({0, Sheets::upper}));
  EXPECT_EQ(numbers(sheets_of("tear")), std::vector<int>({0, Sheets::second_lip}));
  EXPECT_EQ(numbers(sheets_of("slide,tear")), std::vector<int>({0, 1, 2, 3}));
}

TEST(Sheets, BothCoverAGoodPartOfThePicture) {
  for (const std::uint64_t seed : {1U, 2U, 3U, 4U, 5U}) {
    const Sheets s = sheets_of("slide", seed);
    int upper = 0, all = 0;
    for (double v = -230; v <= 230; v += 20)
      for (double u = -310; u <= 310; u += 20, ++all) upper += Sheets::sheet_of(s.place(u, v)) == Sheets::upper;
    EXPECT_GT(upper, all / 5) << seed;
    EXPECT_LT(upper, all * 4 / 5) << seed;
  }
}

TEST(Sheets, TheUpperOneSlidesToAndFroAndTheOtherLiesStill) {
  const Sheets s = sheets_of("slide");
  const auto place = s.place(0, 0);
  const cv::Vec3d rest = s.shift(s.at(0), place, Sheets::upper);
  EXPECT_LT(cv::norm(s.shift(s.at(0.04), place, Sheets::upper) - rest), 0.2);
  double left = 0, right = 0, nearest = 1e9, farthest = 0;
  for (double t = 0; t < 20; t += 0.04) {
    const Sheets::Moment m = s.at(t);
    EXPECT_EQ(s.shift(m, place, 0), cv::Vec3d(0, 0, 0));
    const cv::Vec3d by = s.shift(m, place, Sheets::upper) - rest;
    EXPECT_NEAR(by.dot(by), m.along * m.along + std::pow(m.over - s.at(0).over, 2), 1e-9);
    EXPECT_LE(sideways(s.shift(m, place, Sheets::upper)), s.reach());
    left = std::min(left, m.along);
    right = std::max(right, m.along);
    nearest = std::min(nearest, m.over);
    farthest = std::max(farthest, m.over);
  }
  EXPECT_NEAR(left, -30, 1);
  EXPECT_NEAR(right, 30, 1);
  EXPECT_GT(farthest - nearest, 30);  // a strip is covered and bared
}

// The lower sheet goes on beneath the upper one's edge: no hole opens between them.
TEST(Sheets, NoGapOpensBetweenThem) {
  for (const char *effects : {"slide=0.3", "slide", "slide=4"}) {
    const Sheets s = sheets_of(effects);
    for (double t = 0; t < 15; t += 0.21) {
      const Sheets::Moment m = s.at(t);
      for (double v = -240; v <= 240; v += 3)
        for (double u = -320; u <= 320; u += 3) {
          const auto p = s.place(u, v);
          if (p.inside < 0 || p.inside > 4) continue;
          const cv::Vec3d by = s.shift(m, p, Sheets::upper);
          EXPECT_EQ(Sheets::sheet_of(s.place(u + by[0], v + by[1])), 0) << effects << ' ' << t;
        }
    }
  }
}

/// A point on each lip in the middle of the cut, at this distance from it.
struct Lips {
  Sheets::Place first, second;
};
Lips lips(double beside) {
  Lips l;
  l.first.within = l.second.within = l.first.lens = l.second.lens = 1;
  l.first.beside = -beside;
  l.second.beside = beside;
  return l;
}

TEST(Sheets, ACutOpensInPlaceAndFallsOff) {
  const Sheets s = sheets_of("tear");
  const auto opening = [&](double time, double beside) {
    const Lips l = lips(beside);
    const cv::Vec3d a = s.shift(s.at(time), l.first, 0), b = s.shift(s.at(time), l.second, Sheets::second_lip);
    EXPECT_NEAR(cv::norm(cv::Vec2d(a[0] + b[0], a[1] + b[1])), 0, 1e-9);  // both go equally far
    return sideways(b - a);
  };
  EXPECT_EQ(opening(0, 0), 0);
  EXPECT_EQ(opening(0.79, 0), 0);
  EXPECT_GT(opening(2, 0), 5);
  EXPECT_LT(opening(2, 0), 40);
  EXPECT_NEAR(opening(4, 0), 46, 6);
  EXPECT_NEAR(opening(4, 80) / opening(4, 0), std::exp(-1), 1e-6);
  Sheets::Place end = lips(1).second;
  end.lens = end.within = 0;
  EXPECT_EQ(s.shift(s.at(4), end, Sheets::second_lip), cv::Vec3d(0, 0, 0));
  // It opens in steps: in its quickest frame it moves many times as far as usual.
  std::vector<double> steps;
  for (double t = 0.8; t < 3; t += 0.04) steps.push_back(opening(t + 0.04, 0) - opening(t, 0));
  std::sort(steps.begin(), steps.end());
  EXPECT_GT(steps.back(), 4 * steps[steps.size() / 2]);
}

TEST(Sheets, LipsAreNeverPushedOverEachOther) {
  for (const char *effects : {"tear", "tear=2", "tear=4"}) {
    const Sheets s = sheets_of(effects);
    const auto m = s.at(4);
    double last = 0;
    for (double beside = 0; beside < 300; beside += 0.5) {
      const double at = beside + sideways(s.shift(m, lips(beside).second, Sheets::second_lip));
      EXPECT_TRUE(beside == 0 || at > last) << effects << ' ' << beside;
      last = at;
    }
  }
}

TEST(Sheets, TheBedIsBareOnlyInTheWound) {
  const Sheets s = sheets_of("tear");
  EXPECT_FALSE(Sheets::bared(s.at(0), lips(1).first));
  EXPECT_TRUE(Sheets::bared(s.at(4), lips(1).first));
  EXPECT_FALSE(Sheets::bared(s.at(4), lips(250).first));
  EXPECT_LT(s.shade(s.at(4), lips(23).first, Sheets::bed), s.shade(s.at(4), lips(0).first, Sheets::bed));
}

TEST(Sheets, TheUpperOneThrowsAShadow) {
  const Sheets s = sheets_of("slide");
  const auto m = s.at(0);
  Sheets::Place near, far;
  near.inside = -m.over - 15;
  far.inside = -m.over - 150;
  EXPECT_LT(s.shade(m, near, 0), 0.9);
  EXPECT_GT(s.shade(m, far, 0), 0.99);
}

}  // namespace
}  // namespace csd::sim
