// SPDX-License-Identifier: LGPL-2.1-or-later
#include "csd/tracked_point.h"

#include <gtest/gtest.h>

#include <cmath>
#include <opencv2/imgproc.hpp>

#include "core/csd/scene.h"

namespace csd {
namespace {

/// Leads a point through a frame by hand.
void follow(TrackedPoint &point, const CsdFrame &frame, const NeighbourMap &map) {
  point.first_alignment(frame);
  point.compare_with_map(frame, map);
  point.second_alignment(frame, true);
  point.decide_visibility(frame, {});
  point.update(frame);
  if (point.training_over(frame)) point.freeze_anchor();
}

TEST(TrackedPoint, IsFollowedAndLearnsItsAnchorForTheTrainingTime) {
  Scene scene;
  TrackedPoint point(scene.frame({}), {160, 120});
  point.begin_chart(0);
  for (int i = 1; i <= 14; ++i) {
    const cv::Point2d shift(0.7 * i, -0.4 * i);
    EXPECT_EQ(point.learning(), i <= 13) << i;
    follow(point, scene.frame(shift), Scene::neighbours(shift));
    EXPECT_TRUE(point.visible() && point.reliable());
    EXPECT_LT(cv::norm(point.state().position - cv::Point2d(160, 120) - shift), 0.2) << i;
  }
  EXPECT_LT(point.offset().deviation({}), 1);
}

TEST(TrackedPoint, MayRestOnceAnchoredWhereItsNeighboursPredictIt) {
  Scene scene;
  TrackedPoint point(scene.frame({}), {160, 120}, TrackedPoint::Purpose::support);
  point.begin_chart(0);
  cv::Point2d shift;
  const auto rests = [&](NeighbourMap map) {
    const auto frame = scene.frame(shift);
    follow(point, frame, map);
    return point.may_rest(frame);
  };
  for (int i = 1; i <= 12; ++i) EXPECT_FALSE(rests(Scene::neighbours(shift))) << "it is learning";
  for (int i = 0; i < 3; ++i) {
    shift += {0.4, -0.2};
    EXPECT_TRUE(rests(Scene::neighbours(shift)));
  }
  auto loose = Scene::neighbours(shift);
  loose.spread = 1;  // 2 pixels at 480 lines
  EXPECT_FALSE(rests(loose)) << "its neighbours don't agree";
  EXPECT_TRUE(rests(Scene::neighbours(shift)));
  EXPECT_FALSE(rests(Scene::neighbours(shift + cv::Point2d(0.6, 0)))) << "it is not where they say";
  shift += {3, 0};
  EXPECT_FALSE(rests(Scene::neighbours(shift))) << "it left its course";
  shift += {3, 0};
  ASSERT_TRUE(rests(Scene::neighbours(shift)));

  shift += {3, 0};
  const auto next = scene.frame(shift);
  point.rest();
  point.compare_with_map(next, Scene::neighbours(shift));
  point.follow_map(next);
  EXPECT_TRUE(point.visible());
  EXPECT_FALSE(point.reliable()) << "nothing was seen that could support another point's map";
  EXPECT_NEAR(point.state().position.x, 160 + shift.x, 0.3);
  EXPECT_FALSE(point.may_rest(next)) << "not twice in a row";
}

TEST(TrackedPoint, DoesNotSlideAlongAnEdge) {
  // An upright edge with very little texture along it. That texture moves down, while the tissue moves right.
  const auto picture = [](cv::Point2d shift, double slide) {
    cv::Mat luma(240, 320, CV_8UC1);
    for (int y = 0; y < luma.rows; ++y)
      for (int x = 0; x < luma.cols; ++x)
        luma.at<std::uint8_t>(y, x) = cv::saturate_cast<std::uint8_t>(120 + 60 * std::tanh((x - 160 - shift.x) / 3) +
                                                                      3 * std::sin((y - 120 - slide) / 4));
    return luma;
  };
  Scene scene;
  TrackedPoint point(scene.show(picture({}, 0)), {160, 120});
  point.begin_chart(0);
  for (int i = 1; i <= 60; ++i) {
    const cv::Point2d shift(0.4 * i, 0);
    follow(point, scene.show(picture(shift, 0.1 * i)), Scene::neighbours(shift));
    ASSERT_LT(cv::norm(point.state().position - cv::Point2d(160, 120) - shift), 2) << i;
    ASSERT_LT(std::abs(point.state().position.x - 160 - shift.x), 0.3) << i << ": across the edge it is seen";
  }
}

/// Where a point goes when the picture stays but all others say that the tissue has moved on.
TrackedPoint contradicted(const cv::Mat &picture, cv::Point2d gone) {
  Scene scene;
  TrackedPoint point(scene.show(picture), {160, 120});
  point.begin_chart(0);
  for (int i = 1; i <= 20; ++i) follow(point, scene.show(picture), Scene::neighbours({}));
  follow(point, scene.show(picture), Scene::neighbours(gone));
  return point;
}

TEST(TrackedPoint, TrustsTheNeighboursOverALookAlike) {
  // Dots in rows, all alike.
  cv::Mat dots(240, 320, CV_8UC1, cv::Scalar(60));
  for (int y = 0; y < dots.rows; y += 14)
    for (int x = 4; x < dots.cols; x += 14) cv::circle(dots, {x, y}, 3, cv::Scalar(160), cv::FILLED, cv::LINE_AA);
  const auto point = contradicted(dots, {14, 0});
  EXPECT_LT(cv::norm(point.state().position - cv::Point2d(174, 120)), 0.5) << "where the neighbours put it";
}

TEST(TrackedPoint, TrustsItsOwnPatchWhereNothingElseLooksLikeIt) {
  const auto point = contradicted(Scene().picture({}), {15, 0});
  EXPECT_TRUE(point.visible());
  EXPECT_LT(cv::norm(point.state().position - cv::Point2d(160, 120)), 0.3);
}

// On a border between two sheets, with as many neighbours on both, its own patch says to which it belongs.
TEST(TrackedPoint, ItsAlignmentChoosesBetweenPieces) {
  const cv::Point2d at(160, 120), slide(9, -8);
  for (const auto &motion : {cv::Point2d(), slide}) {
    Scene scene;
    TrackedPoint point(scene.frame({}), at);
    point.begin_chart(0);
    for (int i = 1; i <= 15; ++i) follow(point, scene.frame({}), Scene::neighbours({}));
    NeighbourField field;
    for (std::size_t i = 0; i < 7; ++i) {
      const auto n = static_cast<double>(i);
      const cv::Point2d off(4 + 2 * n, 20 * std::sin(2 * n));
      field.add(2 * i, 0, {at - off, at - off});
      field.add(2 * i + 1, 0, {at + off, at + off + slide});
    }
    const auto frame = scene.frame(motion);
    point.first_alignment(frame);
    ASSERT_TRUE(point.reliable());
    point.compare_with_map(frame, field, NeighbourField::nobody);
    ASSERT_TRUE(point.map());
    EXPECT_LT(cv::norm(point.map()(at) - at - motion), 1);
  }
}

TEST(TrackedPoint, IsFoundAgainWhereTheNeighboursPutIt) {
  Scene scene;
  TrackedPoint point(scene.frame({}), {160, 120});
  point.begin_chart(0);
  for (int i = 1; i <= 15; ++i) follow(point, scene.frame({}), Scene::neighbours({}));
  follow(point, scene.show(cv::Mat(240, 320, CV_8UC1, cv::Scalar(128))), Scene::neighbours({}));
  EXPECT_FALSE(point.visible());
  const cv::Point2d shift(20, -12);
  follow(point, scene.frame(shift), Scene::neighbours(shift + cv::Point2d(0.6, 0.3)));
  EXPECT_TRUE(point.visible());
  EXPECT_LT(cv::norm(point.state().position - cv::Point2d(160, 120) - shift), 0.2);
}

TEST(TrackedPoint, WithoutAMapItClaimsNothingUnlessUnique) {
  Scene scene;
  TrackedPoint point(scene.frame({}), {160, 120});
  const auto frame = scene.frame({1, 1});
  point.first_alignment(frame);
  point.compare_with_map(frame, NeighbourMap{});
  point.second_alignment(frame, true);
  point.decide_visibility(frame, {});
  EXPECT_FALSE(point.visible());
  Surroundings none;
  none.alone = true;
  const auto again = scene.frame({1, 1});
  point.first_alignment(again);
  point.compare_with_map(again, NeighbourMap{});
  point.second_alignment(again, false);
  EXPECT_FALSE(point.reliable());
  point.second_alignment(again, true);
  point.decide_visibility(again, none);
  EXPECT_TRUE(point.visible());
}

TEST(TrackedPoint, AfterAJumpItClaimsNothingUntilItFitsAgain) {
  const auto visible_in = [](double share, bool jumped) {
    Scene scene;
    TrackedPoint point(scene.frame({}), {160, 120});
    point.begin_chart(0);
    for (int i = 1; i <= 15; ++i) follow(point, scene.frame({}), Scene::neighbours({}));
    if (jumped) {
      point.hide_until_found();
      EXPECT_FALSE(point.visible() || point.reliable());
    }
    // Another texture shines through, and there are no neighbours.
    cv::Mat here, other;
    cv::cvtColor(MovingScene().render({}), here, cv::COLOR_BGR2GRAY);
    cv::cvtColor(MovingScene({320, 240}, 9).render({}), other, cv::COLOR_BGR2GRAY);
    cv::addWeighted(here, share, other, 1 - share, 0, here);
    const auto frame = scene.show(here);
    Surroundings none;
    none.alone = true;
    point.first_alignment(frame);
    point.compare_with_map(frame, NeighbourMap{});
    point.second_alignment(frame, true);
    point.decide_visibility(frame, none);
    return point.visible();
  };
  EXPECT_TRUE(visible_in(1, true));
  EXPECT_TRUE(visible_in(0.45, false));
  EXPECT_FALSE(visible_in(0.45, true));
}

TEST(TrackedPoint, AWaitingPointFollowsItsNeighboursWithFadingConfidence) {
  Scene scene;
  TrackedPoint point(scene.frame({}), {160, 120});
  point.begin_chart(0);
  for (int i = 1; i <= 15; ++i) follow(point, scene.frame({}), Scene::neighbours({}));
  const double seen_with = point.confidence();
  const auto first = point.urgency(scene.frame({}));
  for (int i = 1; i <= 3; ++i) {
    const auto frame = scene.frame({});
    point.wait();
    point.compare_with_map(frame, Scene::neighbours({3.0 * i, 0}));
    point.follow_map(frame);
    EXPECT_TRUE(point.visible());
    EXPECT_FALSE(point.reliable());
    EXPECT_NEAR(point.state().position.x, 160 + 3 * i, 0.05);
    EXPECT_NEAR(point.confidence(), seen_with * std::pow(0.5, i / 100.0), 1e-9) << "it halves in 100 frames";
    EXPECT_GT(point.urgency(frame), first * i);
  }
  const auto frame = scene.frame({});
  point.wait();
  point.compare_with_map(frame, NeighbourMap{});
  point.follow_map(frame);
  EXPECT_FALSE(point.visible()) << "nothing says where it went";
  EXPECT_EQ(point.confidence(), 0);
}

TEST(TrackedPoint, ASupportPointIsFollowedToo) {
  // It begins in motion and moves steadily. Then it jumps farther than its finest level can bridge, stops, and is not
  // aligned for five frames' time.
  std::vector<std::pair<cv::Point2d, double>> frames;
  for (int i = 1; i <= 20; ++i) frames.push_back({{2.5 * i, -1.0 * i}, 1});
  frames.push_back({{56, -14}, 1});
  for (int i = 0; i < 5; ++i) frames.push_back({{56, -14}, 1});
  frames.push_back({{48, -10}, 5});
  Scene scene;
  TrackedPoint point(scene.frame({}), {160, 120}, TrackedPoint::Purpose::support);
  point.begin_chart(0);
  for (std::size_t i = 0; i < frames.size(); ++i) {
    const auto [shift, steps] = frames[i];
    auto frame = scene.frame(shift);
    frame.steps = steps;
    point.first_alignment(frame);
    EXPECT_TRUE(point.reliable()) << i << ": from its own motion alone";
    point.compare_with_map(frame, Scene::neighbours(shift));
    point.second_alignment(frame, true);
    point.decide_visibility(frame, {});
    point.update(frame);
    if (point.training_over(frame)) point.freeze_anchor();
    EXPECT_TRUE(point.visible()) << i;
    EXPECT_LT(cv::norm(point.state().position - cv::Point2d(160, 120) - shift), 0.3) << i;
  }
}

TEST(TrackedPoint, AnotherPatchSizeScalesItsShape) {
  for (const double patch : {0.6, 2.0}) {
    Scene scene;
    const auto framed = [&](cv::Point2d shift) {
      auto frame = scene.frame(shift);
      frame.patch = patch;
      return frame;
    };
    TrackedPoint point(framed({}), {160, 120});
    point.begin_chart(0);
    for (int i = 1; i <= 20; ++i) {
      const cv::Point2d shift(0.7 * i, -0.4 * i);
      follow(point, framed(shift), Scene::neighbours(shift));
      EXPECT_TRUE(point.visible() && point.reliable());
      EXPECT_LT(cv::norm(point.state().position - cv::Point2d(160, 120) - shift), 0.2) << i;
      EXPECT_NEAR(point.state().scale(), patch, 0.05 * patch);
    }
  }
}

}  // namespace
}  // namespace csd
