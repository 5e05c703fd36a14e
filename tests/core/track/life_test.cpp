// SPDX-License-Identifier: LGPL-2.1-or-later
#include "track/life.h"

#include <gtest/gtest.h>

#include <limits>

namespace csd {
namespace {

using Kind = Claim::Kind;
constexpr std::int64_t frame = second / 25;

Life seen_at(cv::Point2d position, std::int64_t time = 0) {
  Life life;
  life.apply({0, Kind::tracked, position, 1}, time);
  return life;
}

TEST(Life, AHiddenFeatureIsOccludedForASecondThenLost) {
  auto life = seen_at({100, 100});
  for (int i = 1; i < 25; ++i) {
    life.apply({0, Kind::hidden, {100.0 + i, 90}}, i * frame);
    EXPECT_EQ(life.feature.state, FeatureState::occluded) << i;
    EXPECT_EQ(life.feature.x, 100 + i) << "a prediction";
  }
  life.apply({0, Kind::hidden, {130, 90}}, second);
  EXPECT_EQ(life.feature.state, FeatureState::lost);
  EXPECT_EQ(life.feature.x, 100) << "the last claim";
  EXPECT_EQ(life.gone_since, second);
  life.apply({0, Kind::tracked, {140, 80}}, second + frame);
  EXPECT_EQ(life.feature.state, FeatureState::tracked);
  EXPECT_EQ(life.feature.y, 80);
}

TEST(Life, TheEndIsAtTheLastClaim) {
  auto life = seen_at({100, 100});
  life.apply({0, Kind::hidden, {120, 90}, 0.3}, frame);
  life.end();
  EXPECT_EQ(life.feature.state, FeatureState::ended);
  EXPECT_EQ(life.feature.confidence, 0);
  EXPECT_EQ(life.feature.x, 100);
  EXPECT_EQ(life.feature.y, 100);
}

TEST(Life, AFeatureHiddenWhileLearningStartedFalsely) {
  const auto hidden_after = [](Kind before, bool given, bool fresh, Kind now = Kind::hidden, bool surrounded = true) {
    Life life;
    life.given = given;
    life.apply({0, before, {100, 100}, 1}, 0);
    life.reported = true;
    life.reported_as = life.feature.state;
    EXPECT_FALSE(life.started_falsely());
    Claim claim{0, now, {100, 100}};
    claim.fresh = fresh;
    claim.surrounded = surrounded;
    life.apply(claim, frame);
    return life.started_falsely();
  };
  EXPECT_TRUE(hidden_after(Kind::learning, false, true));
  EXPECT_TRUE(hidden_after(Kind::learning, false, true, Kind::lost));
  EXPECT_FALSE(hidden_after(Kind::tracked, false, true)) << "something came in front of it";
  EXPECT_FALSE(hidden_after(Kind::learning, true, true)) << "the user's own";
  EXPECT_FALSE(hidden_after(Kind::learning, false, false)) << "not looked at";
  EXPECT_FALSE(hidden_after(Kind::learning, false, true, Kind::out));
  EXPECT_FALSE(hidden_after(Kind::learning, false, true, Kind::tracked));
  EXPECT_FALSE(hidden_after(Kind::learning, false, true, Kind::hidden, false)) << "everything around it is hidden, too";
}

TEST(Life, AFeatureOutsideThePictureIsOutUntilSeenAgain) {
  auto life = seen_at({319, 100});
  life.apply({0, Kind::out, {321, 100}}, frame);
  EXPECT_EQ(life.feature.state, FeatureState::out);
  EXPECT_EQ(life.feature.x, 319) << "the last claim";
  life.apply({0, Kind::hidden, {318, 100}}, 2 * frame);
  EXPECT_EQ(life.feature.state, FeatureState::out);
  EXPECT_EQ(life.gone_since, frame);
  life.apply({0, Kind::tracked, {318, 100}}, 3 * frame);
  EXPECT_EQ(life.feature.state, FeatureState::tracked);
}

TEST(Life, ConfidenceIsAtLeastAHalfExactlyWhereAPositionIsClaimed) {
  const struct {
    Kind kind;
    double said, told;
  } cases[] = {{Kind::tracked, 0.5, 0.5}, {Kind::learning, 0.93, 0.93},
               {Kind::hidden, 0.3, 0.3},  {Kind::hidden, 0.4999, 0.499},  // as three decimals: a half
               {Kind::hidden, 1, 0},                                      // from an algorithm without probabilities
               {Kind::lost, 0.3, 0},      {Kind::out, 0.3, 0}};
  for (const auto &c : cases) {
    auto life = seen_at({100, 100});
    life.apply({0, c.kind, {100, 100}, c.said}, frame);
    EXPECT_EQ(life.feature.confidence, c.told) << static_cast<int>(c.kind) << ' ' << c.said;
  }
  auto lost = seen_at({100, 100});
  lost.apply({0, Kind::hidden, {100, 100}, 0.3}, second);
  EXPECT_EQ(lost.feature.confidence, 0);
}

TEST(Life, APositionIsFiniteWhateverTheAlgorithmSays) {
  constexpr double nan = std::numeric_limits<double>::quiet_NaN();
  auto life = seen_at({100, 90});
  for (const auto kind : {Kind::tracked, Kind::hidden, Kind::out}) {
    life.apply({0, kind, {nan, 1}}, frame);
    EXPECT_EQ(life.feature.x, 100);
    EXPECT_EQ(life.feature.y, 90);
  }
}

}  // namespace
}  // namespace csd
