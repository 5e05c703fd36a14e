// SPDX-License-Identifier: LGPL-2.1-or-later
#include "csd/steps.h"

#include <gtest/gtest.h>

#include <vector>

#include "core/csd/scene.h"

namespace csd {
namespace {

/// A field in which all tissue moves by `shift`.
NeighbourField moved(cv::Point2d shift) {
  NeighbourField field;
  for (std::size_t i = 0; i < 25; ++i) {
    const cv::Point2d at(100 + 30.0 * static_cast<double>(i % 5), 60 + 30.0 * static_cast<double>(i / 5));
    field.add(1000 + i, 0, {at, at + shift});
  }
  return field;
}

struct Steps : testing::Test {
  Scene scene;
  std::vector<Followed> points;
  Points turns;
  std::size_t resting = 99;
  bool searches = true;

  void begin(std::size_t n) {
    const auto frame = scene.frame({});
    for (std::size_t i = 0; i < n; ++i) {
      points.push_back({TrackedPoint(frame, {120 + 20.0 * static_cast<double>(i), 120}), i});
      points.back().point.begin_chart(0);
    }
    for (auto &p : points) turns.push_back(&p);
  }
  void follow(const CsdFrame &frame, const NeighbourField &field) {
    order_by_urgency(frame, turns);
    first_alignments(frame, turns, {}, [this](const Followed &p) { return p.id == resting; });
    compare_with_maps(frame, turns, field, Among::others);
    second_alignments(frame, turns, {}, false, [this](const Followed &) { return searches; });
    compare_unmapped(frame, turns, field, Among::others);
    decide_visibility(frame, turns, {});
    update_models(frame, turns);
  }
  void follow_to(cv::Point2d shift, FrameBudget budget = {}) {
    auto frame = scene.frame(shift);
    frame.budget = budget;
    follow(frame, moved(shift));
  }
};

TEST_F(Steps, TakeAPointThroughFramesUntilItHasItsAnchor) {
  begin(3);
  for (int i = 1; i <= 13; ++i) {
    for (const auto &p : points) EXPECT_TRUE(p.point.learning()) << i;
    follow_to({0.5 * i, 0.3 * i});
    for (const auto &p : points) {
      EXPECT_TRUE(p.point.reliable() && p.turn == Followed::Turn::aligns);
      EXPECT_LT(cv::norm(p.point.state().position - cv::Point2d(120 + 20.0 * p.id + 0.5 * i, 120 + 0.3 * i)), 0.2);
    }
  }
  for (const auto &p : points) EXPECT_FALSE(p.point.learning());
}

TEST_F(Steps, ComparesPointsWithoutAMapAgainWhenMoreIsKnown) {
  begin(2);
  const auto frame = scene.frame({});
  const auto mapped_to = [&](std::size_t i) { return points[i].point.map()({0, 0}); };
  compare_with_maps(frame, turns, {}, Among::others);
  for (const auto &p : points) EXPECT_FALSE(p.point.map());
  compare_with_maps(frame, {&points[0]}, moved({1, 0}), Among::others);
  compare_unmapped(frame, turns, moved({2, 0}), Among::others);
  ASSERT_TRUE(points[0].point.map() && points[1].point.map());
  EXPECT_NEAR(mapped_to(0).x, 1, 1e-6) << "it has a map already";
  EXPECT_NEAR(mapped_to(1).x, 2, 1e-6);
}

TEST_F(Steps, APointInTheFieldIsLeftOutOfItsOwnMap) {
  begin(1);
  const auto frame = scene.frame({});
  // Four points move by one pixel; the fifth, the point itself, by a hundred.
  NeighbourField field;
  for (std::size_t i = 1; i < 5; ++i) {
    const cv::Point2d at(100 + 40.0 * static_cast<double>(i % 2), 100 + 40.0 * static_cast<double>(i / 2));
    field.add(i, 0, {at, at + cv::Point2d(1, 0)});
  }
  field.add(0, 0, {{120, 120}, {220, 120}});
  compare_with_maps(frame, turns, field, Among::themselves);
  EXPECT_EQ(points[0].point.map().support, 4u);
  EXPECT_NEAR(points[0].point.map()({120, 120}).x, 121, 1e-6);
  compare_with_maps(frame, turns, field, Among::others);
  EXPECT_EQ(points[0].point.map().support, 5u);
}

TEST_F(Steps, ARestingPointFollowsItsNeighbours) {
  begin(2);
  follow_to({});
  resting = 1;
  follow_to({2, 0});
  EXPECT_EQ(points[1].turn, Followed::Turn::rests);
  EXPECT_TRUE(points[1].point.visible());
  EXPECT_FALSE(points[1].point.reliable());
  EXPECT_NEAR(points[1].point.state().position.x, 142, 0.05);
}

TEST_F(Steps, SearchForHiddenPointsOnlyWhenAsked) {
  begin(1);
  follow_to({});
  follow(scene.show(cv::Mat(240, 320, CV_8UC1, cv::Scalar(100))), moved({}));
  ASSERT_FALSE(points[0].point.visible());
  searches = false;
  follow_to({});
  EXPECT_FALSE(points[0].point.visible());
  searches = true;
  follow_to({});
  EXPECT_TRUE(points[0].point.visible());
}

TEST_F(Steps, PastTheBudgetTheMostUrgentGoesFirst) {
  begin(3);
  follow_to({});
  const FrameBudget::Clock late = [now = std::int64_t{0}]() mutable { return now += 100; };
  std::vector<int> times(3);
  for (int i = 0; i < 6; ++i) {
    follow_to({}, FrameBudget(1, late));
    int aligned = 0;
    for (const auto &p : points) {
      aligned += p.turn == Followed::Turn::aligns;
      times[p.id] += p.turn == Followed::Turn::aligns;
      EXPECT_TRUE(p.turn == Followed::Turn::aligns || p.turn == Followed::Turn::waits);
      EXPECT_TRUE(p.point.visible()) << "confidence fades slowly";
    }
    EXPECT_EQ(aligned, 1) << "one, however late";
  }
  EXPECT_EQ(times, std::vector<int>({2, 2, 2})) << "each has its turn";
}

}  // namespace
}  // namespace csd
