// SPDX-License-Identifier: LGPL-2.1-or-later
#include "csd/neighbour_map.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace csd {
namespace {

const cv::Point2d at{100, 80};

/// Fourteen points on a spiral about `at`, nearest first, moved by `motion`.
template <class Motion>
std::vector<Correspondence> around(Motion motion) {
  std::vector<Correspondence> points;
  for (int i = 0; i < 14; ++i) {
    const double angle = 2.4 * i, far = 15 + 6 * i;
    const auto from = at + far * cv::Point2d(std::cos(angle), std::sin(angle));
    points.push_back({from, motion(from)});
  }
  return points;
}

cv::Point2d turned(cv::Point2d p) {  // a similarity: 1.2 times as large, turned by 30°
  const double c = 1.2 * std::cos(CV_PI / 6), s = 1.2 * std::sin(CV_PI / 6);
  return {c * p.x - s * p.y + 7, s * p.x + c * p.y - 3};
}

cv::Point2d sheared(cv::Point2d p) {
  return {1.1 * p.x + 0.1 * p.y - 20, 0.9 * p.y + 12};
}

void expect_near(cv::Point2d a, cv::Point2d b, double within) {
  EXPECT_NEAR(a.x, b.x, within);
  EXPECT_NEAR(a.y, b.y, within);
}

TEST(NeighbourMap, FindsTheMotionOfThePoints) {
  const auto similarity = fit_neighbours(around(turned), at, 1, {});
  EXPECT_EQ(similarity.support, 14u);
  expect_near(similarity(at), turned(at), 1e-9);
  EXPECT_NEAR(similarity.scale(), 1.2, 1e-9);
  EXPECT_EQ(similarity.spread, 0.5) << "at its floor: all agree";
  expect_near(similarity.inverse(turned({90, 70})), {90, 70}, 1e-9);
  // The ridge of 60 px² hardly changes an affine map.
  const auto affine = fit_neighbours(around(sheared), at, 1, {});
  expect_near(affine(at), sheared(at), 0.05);
  EXPECT_NEAR(affine.linear(0, 0), 1.1, 0.005);
  EXPECT_NEAR(affine.linear(0, 1), 0.1, 0.005);
}

TEST(NeighbourMap, IgnoresTheFewThatMoveDifferently) {
  auto points = around(turned);
  for (const std::size_t i : {1, 4, 8}) points[i].to += cv::Point2d(60, -40);
  expect_near(fit_neighbours(points, at, 1, {})(at), turned(at), 0.3);
}

/// Two sheets that meet at x = `border`: the right one has slid by 40 px.
std::vector<Correspondence> two_sheets(double border) {
  return around([=](cv::Point2d p) { return turned(p) + (p.x > border ? cv::Point2d(30, -26) : cv::Point2d()); });
}

TEST(NeighbourMap, FollowsThePieceOfMostOfTheNearest) {
  for (const double aside : {-18.0, 18.0}) {
    const auto map = fit_neighbours(two_sheets(at.x + aside), at, 1, {});
    expect_near(map(at), turned(at) + (aside < 0 ? cv::Point2d(30, -26) : cv::Point2d()), 0.5);
    EXPECT_LT(map.spread, 1);
    EXPECT_LT(map.support, 14u) << "those of its piece";
  }
}

TEST(NeighbourMap, BelongsToThePieceThatMovesAsThePointItself) {
  std::vector<Correspondence> points;  // as many on both sides of the border, equally far
  const cv::Point2d slide(30, -26);
  for (int i = 0; i < 7; ++i) {
    const cv::Point2d off(8 + 4 * i, 40 * std::sin(2 * i));
    points.push_back({at - off, at - off});
    points.push_back({at + off, at + off + slide});
  }
  for (const auto &motion : {cv::Point2d(), slide}) {
    const Correspondence own{at, at + motion + cv::Point2d(0.5, 0.5)};
    expect_near(fit_neighbours(points, at, 1, {}, &own)(at), at + motion, 0.5);
  }
}

TEST(NeighbourMap, FitsOneMotionToPointsThatAreOnlyNoisy) {
  auto points = around(turned);
  for (std::size_t i = 0; i < points.size(); ++i) points[i].to += cv::Point2d(i % 2 ? 2.1 : -2.1, i % 3 ? 1.4 : -2.8);
  Tuning one;
  one.common_spread = 1e9;
  const auto map = fit_neighbours(points, at, 1, {});
  EXPECT_GT(map.spread, Tuning().common_spread) << "so much noise that there might be pieces";
  EXPECT_EQ(map.linear, fit_neighbours(points, at, 1, one).linear);
}

TEST(NeighbourMap, NeedsThreePointsThatAgree) {
  const auto points = around(sheared);
  EXPECT_FALSE(fit_neighbours({points.data(), 2}, at, 1, {}));
  const auto three = fit_neighbours({points.data(), 3}, at, 1, {});
  EXPECT_EQ(three.support, 3u);
  EXPECT_EQ(three.linear(0, 0), three.linear(1, 1)) << "three points make a similarity";
  EXPECT_EQ(three.linear(0, 1), -three.linear(1, 0));
  auto scattered = points;
  for (std::size_t i = 0; i < scattered.size(); ++i) scattered[i].to = scattered[(5 * i + 3) % 14].from;
  EXPECT_FALSE(fit_neighbours(scattered, at, 1, {})) << "no two agree";
}

TEST(NeighbourField, TakesTheChartsNearestPointsWithoutTheOwner) {
  NeighbourField field;
  const auto points = around(turned);
  for (std::size_t i = 0; i < points.size(); ++i) field.add(i, 0, points[i]);
  for (std::size_t i = 0; i < 4; ++i) field.add(100 + i, 1, {points[i].from, points[i].from});
  // Farther points, which move differently, have no effect.
  for (std::size_t i = 0; i < 14; ++i) field.add(200 + i, 0, {points[i].from + cv::Point2d(400, 0), {0, 0}});
  expect_near(field.map_at(at, 0, 1, {})(at), turned(at), 1e-9);
  expect_near(field.inverse_map_at(turned(at), 0, 1, {})(turned(at)), at, 1e-9);
  EXPECT_EQ(field.map_at(at, 1, 1, {}).support, 4u);
  EXPECT_EQ(field.map_at(at, 1, 1, {}, 102).support, 3u);
  EXPECT_FALSE(field.map_at(at, 2, 1, {}));
  const auto map = field.map_at(at, 0, 1, {});
  EXPECT_GT(map.nearby, std::pow(cv::norm(points.back().from - at), 2));
  // The hint is right, too small, or absent.
  for (const double nearby : {map.nearby, 1.0, 0.0})
    EXPECT_EQ(field.map_at(at, 0, 1, {}, NeighbourField::nobody, nearby).linear, map.linear) << nearby;
  EXPECT_TRUE(std::isinf(field.map_at(at, 1, 1, {}).nearby)) << "fewer points than a map can use";
  field.drop_small_charts(5);
  EXPECT_FALSE(field.map_at(at, 1, 1, {}));
  EXPECT_EQ(field.size(), 28u);
}

/// Information of a patch whose position has the sds `along` and `across` (px), the first in direction (cos, sin).
cv::Matx22d knows(double along, double across, double angle = 0) {
  const double c = std::cos(angle), s = std::sin(angle), i = 1 / (along * along), j = 1 / (across * across);
  return {i * c * c + j * s * s, (i - j) * s * c, (i - j) * s * c, i * s * s + j * c * c};
}

TEST(PositionCovariance, IsTheInverseByDirection) {
  const auto corner = position_covariance(knows(0.2, 0.2));
  EXPECT_NEAR(corner(0, 0), 0.04, 1e-4);
  EXPECT_NEAR(corner(1, 1), 0.04, 1e-4);
  EXPECT_NEAR(corner(0, 1), 0, 1e-9);
  const double angle = 0.6;
  const auto edge = position_covariance(knows(0.5, 0.1, angle));
  const cv::Vec2d along(std::cos(angle), std::sin(angle)), across(-along[1], along[0]);
  EXPECT_NEAR(along.dot(edge * along), 0.25, 1e-3);
  EXPECT_NEAR(across.dot(edge * across), 0.01, 1e-4);
  // Zero information gives a finite covariance.
  EXPECT_NEAR(position_covariance(cv::Matx22d::zeros())(0, 0), 1000, 1e-6);
}

TEST(NeighbourOffset, LearnsWhereAPointLiesRelativeToItsNeighbours) {
  const auto map = fit_neighbours(around(turned), at, 1, {});
  const cv::Point2d beside{2, -1};
  const cv::Matx22d shape(1, 0.1, 0, 1), information = knows(0.05, 0.05);
  NeighbourOffset offset;
  EXPECT_EQ(offset.deviation({}), 2);
  expect_near(offset.predict(map, at).position, turned(at), 1e-9);
  const AffineState seen{turned(at + beside), map.linear * shape};
  for (int i = 0; i < 400; ++i) offset.update(map, at, seen, information, 1, 1, {});
  expect_near(offset.offset(), beside, 0.02);
  EXPECT_EQ(offset.deviation({}), 0.3) << "at its floor";
  expect_near(offset.predict(map, at).position, seen.position, 0.03);
  EXPECT_NEAR(offset.predict(map, at).shape(0, 1), seen.shape(0, 1), 0.01);
  // One wild frame can't drag it away: the deviation is clipped, and the mean takes a fiftieth.
  offset.update(map, at, {turned(at + beside + cv::Point2d(50, 0)), seen.shape}, information, 1, 1, {});
  EXPECT_LT(offset.offset().x, beside.x + 1.1);
  EXPECT_LT(offset.deviation({}), 0.5);
}

TEST(NeighbourOffset, TrustsAPatchAsFarAsItIsLocated) {
  const NeighbourMap map{cv::Matx22d::eye(), {}, 0.5, 14};
  // sd 1 px, against the 1 px by which tissue differs from its neighbours: half of it counts.
  NeighbourOffset faint;
  for (int i = 0; i < 400; ++i)
    faint.update(map, at, {at + cv::Point2d(2, -1), cv::Matx22d::eye()}, knows(1, 1), 1, 1, {});
  expect_near(faint.offset(), {1, -0.5}, 0.02);
  // Along a level edge it counts less than across.
  NeighbourOffset edge;
  for (int i = 0; i < 400; ++i)
    edge.update(map, at, {at + cv::Point2d(2, 2), cv::Matx22d::eye()}, knows(3, 0.1), 1, 1, {});
  expect_near(edge.offset(), {0.2, 2 / 1.01}, 0.02);
}

TEST(NeighbourOffset, IsNeverFarFromTheNeighbours) {
  const NeighbourMap map{cv::Matx22d::eye(), {}, 0.5, 14};
  NeighbourOffset offset;
  for (int i = 0; i < 2000; ++i)
    offset.update(map, at, {at + cv::Point2d(0.02 * i, 0), cv::Matx22d::eye()}, knows(0.05, 0.05), 1, 1, {});
  EXPECT_LE(offset.offset().x, 6);
  EXPECT_GT(offset.offset().x, 5.5);
}

}  // namespace
}  // namespace csd
