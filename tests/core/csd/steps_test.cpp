// SPDX-License-Identifier: LGPL-2.1-or-later
#include "csd/steps.h"

#include <gtest/gtest.h>

#include <string>

#include "core/csd/scene.h"

namespace csd {
namespace {

/// A field in which all tissue moves by `shift`. Records the calls in order.
class Around final : public Company {
 public:
  void moved(cv::Point2d shift) {
    field_.clear();
    for (std::size_t i = 0; i < 25; ++i) {
      const cv::Point2d at(100 + 30.0 * static_cast<double>(i % 5), 60 + 30.0 * static_cast<double>(i / 5));
      field_.add(1000 + i, 0, {at, at + shift});
    }
  }
  const NeighbourField &field() const override { return field_; }
  const Surroundings &surroundings() const override { return around_; }
  bool may_rest(const CsdFrame &, const Followed &point) const override { return point.id == resting; }
  bool searched_for(const Followed &) const override { return searches; }
  void gather(const CsdFrame &) override { calls += 'g'; }
  void met(const CsdFrame &) override { calls += 'm'; }
  void looked(const CsdFrame &) override { calls += 'l'; }

  std::size_t resting = 99;
  bool searches = true;
  std::string calls;

 private:
  NeighbourField field_;
  Surroundings around_;
};

struct Steps : testing::Test {
  Scene scene;
  Around around;
  std::vector<Followed> points;
  std::vector<Followed *> turns;

  void begin(std::size_t n) {
    around.moved({});
    const auto frame = scene.frame({});
    for (std::size_t i = 0; i < n; ++i) {
      points.push_back({TrackedPoint(frame, {120 + 20.0 * static_cast<double>(i), 120}), i});
      points.back().point.found(0);
    }
    for (auto &p : points) turns.push_back(&p);
  }
  void follow_to(cv::Point2d shift, FrameBudget budget = {}) {
    around.moved(shift);
    auto frame = scene.frame(shift);
    frame.budget = budget;
    follow(frame, turns, around, {});
  }
};

TEST_F(Steps, TakeAPointThroughFramesUntilItHasItsAnchor) {
  begin(3);
  for (int i = 1; i <= 13; ++i) {
    for (const auto &p : points) EXPECT_TRUE(p.point.learning()) << i;
    follow_to({0.5 * i, 0.3 * i});
    for (const auto &p : points) {
      EXPECT_TRUE(p.point.sure() && p.turn == Followed::Turn::looks);
      EXPECT_LT(cv::norm(p.point.state().position - cv::Point2d(120 + 20.0 * p.id + 0.5 * i, 120 + 0.3 * i)), 0.2);
    }
  }
  for (const auto &p : points) EXPECT_FALSE(p.point.learning());
}

TEST_F(Steps, AskTheCompanyAgainWhenMoreIsKnown) {
  begin(1);
  follow_to({});
  EXPECT_EQ(around.calls, "gmglg");
}

TEST_F(Steps, ARestingPointFollowsItsNeighbours) {
  begin(2);
  follow_to({});
  around.resting = 1;
  follow_to({2, 0});
  EXPECT_EQ(points[1].turn, Followed::Turn::rests);
  EXPECT_TRUE(points[1].point.visible());
  EXPECT_FALSE(points[1].point.sure());
  EXPECT_NEAR(points[1].point.state().position.x, 142, 0.05);
}

TEST_F(Steps, SearchForHiddenPointsWhenTheCompanySaysSo) {
  begin(1);
  follow_to({});
  around.moved({});
  follow(scene.show(cv::Mat(240, 320, CV_8UC1, cv::Scalar(100))), turns, around, {});
  ASSERT_FALSE(points[0].point.visible());
  around.searches = false;
  follow_to({});
  EXPECT_FALSE(points[0].point.visible());
  around.searches = true;
  follow_to({});
  EXPECT_TRUE(points[0].point.visible());
}

TEST_F(Steps, PastTheBudgetTheMostUrgentGoesFirst) {
  begin(3);
  follow_to({});
  const FrameBudget::Clock late = [now = std::int64_t{0}]() mutable { return now += 100; };
  std::vector<int> looks(3);
  for (int i = 0; i < 6; ++i) {
    follow_to({}, FrameBudget(1, late));
    int looked = 0;
    for (const auto &p : points) {
      looked += p.turn == Followed::Turn::looks;
      looks[p.id] += p.turn == Followed::Turn::looks;
      EXPECT_TRUE(p.turn == Followed::Turn::looks || p.turn == Followed::Turn::waits);
      EXPECT_TRUE(p.point.visible()) << "confidence fades slowly";
    }
    EXPECT_EQ(looked, 1) << "one, however late";
  }
  EXPECT_EQ(looks, std::vector<int>({2, 2, 2})) << "each has its turn";
}

}  // namespace
}  // namespace csd
