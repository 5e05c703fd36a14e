// SPDX-License-Identifier: LGPL-2.1-or-later
#include "csd/support_points.h"

#include <gtest/gtest.h>

#include <opencv2/imgproc.hpp>

#include "base/types.h"
#include "image/work_frame.h"
#include "track/moving_scene.h"

namespace csd {
namespace {

class Support : public testing::Test {
 protected:
  void show(const cv::Mat &bgr, const FrameBudget &budget = {}) {
    cv::Mat luma;
    cv::cvtColor(bgr, luma, cv::COLOR_BGR2GRAY);
    frame_.load(MovingScene::view(bgr));
    pyramid_.build(luma);
    glare_.build(frame_, {});
    const CsdFrame frame{.pyramid = pyramid_,
                         .weights = glare_,
                         .size = luma.size(),
                         .unit = luma.rows / 480.0,
                         .time = time_ += second / 25,
                         .training_time = second / 2,
                         .budget = budget,
                         .colour = &frame_,
                         .tuning = tuning_};
    support_.follow(frame);
    support_.replenish(frame);
  }
  void show_scene(cv::Point2d shift) { show(scene_.render(shift)); }
  cv::Point2d moved(cv::Point2d from) const { return support_.field().map_at(from, support_.chart(), 0.5, {})(from); }

  MovingScene scene_;
  WorkFrame frame_;
  Pyramid pyramid_;
  GlareWeights glare_;
  Tuning tuning_;
  SupportPoints support_;
  std::int64_t time_ = 0;
};

TEST_F(Support, CoversThePictureAndKnowsItsMotion) {
  show_scene({});
  EXPECT_GT(support_.size(), 160u);  // 320 × 240 has 20 × 15 cells
  for (int i = 1; i <= 10; ++i) show_scene({1.0 * i, 0.5 * i});
  EXPECT_GT(support_.field().size(), 120u);
  for (const cv::Point2d p : {cv::Point2d(50, 50), {160, 120}, {280, 200}}) {
    EXPECT_NEAR(moved(p).x, p.x + 10, 0.2);
    EXPECT_NEAR(moved(p).y, p.y + 5, 0.2);
  }
}

TEST_F(Support, AVeryWidePictureHasABoundedNumberOfPoints) {
  const cv::Mat wide = cv::repeat(scene_.render({}).rowRange(100, 132), 1, 25);  // 8000 × 32
  for (int i = 0; i < 20; ++i) show(wide);
  EXPECT_GT(support_.size(), 200u);
  EXPECT_LE(support_.size(), 2400u);  // two in each of 1200 cells; before the bound there were 60000
}

TEST_F(Support, InCalmTissueHalfOfThePointsRestAndTheMapsStay) {
  show_scene({});
  const auto all = support_.size();
  for (int i = 1; i <= 40; ++i) show_scene({0.1 * i, 0.2 * i});
  for (int i = 41; i <= 50; ++i) {
    show_scene({0.1 * i, 0.2 * i});
    EXPECT_GT(support_.field().size(), 2 * all / 5);
    EXPECT_LT(support_.field().size(), 3 * all / 5);
    for (const cv::Point2d p : {cv::Point2d(50, 50), {160, 120}, {280, 200}})
      EXPECT_LT(cv::norm(moved(p) - p - cv::Point2d(0.1 * i, 0.2 * i)), 0.1) << i;
  }
  for (int i = 0; i < 4; ++i) show_scene({5.0 + 3 * (i % 2), 10});
  EXPECT_GT(support_.field().size(), 3 * all / 4) << "moving points are aligned in each frame";
}

TEST_F(Support, NoneBeginsOnATool) {
  cv::Mat bgr = scene_.render({}), gray;
  auto tool = bgr(cv::Rect(0, 0, 160, 240));
  cv::cvtColor(tool, gray, cv::COLOR_BGR2GRAY);
  cv::cvtColor(gray, tool, cv::COLOR_GRAY2BGR);
  show(bgr);
  EXPECT_LE(support_.size(), 150u);  // 10 × 15 cells are tissue
  EXPECT_GT(support_.size(), 120u);
}

TEST_F(Support, WithLittleTimeVisiblePointsStillCarryTheMaps) {
  const FrameBudget::Clock clock = [now = std::int64_t{0}]() mutable { return now++; };
  const cv::Mat cover = MovingScene({320, 240}, 9).render({});
  for (int i = 0; i <= 40; ++i) show_scene({0.5 * i, 0});
  for (int i = 41; i <= 110; ++i) {
    const double x = 0.25 * (i + 40);
    cv::Mat bgr = scene_.render({x, 0});
    // A cover comes in from the left, until a sixth of the picture is left.
    const cv::Rect hidden(0, 0, std::min(5 * (i - 50), 265), 240);
    if (i > 50) cover(hidden).copyTo(bgr(hidden));
    show(bgr, FrameBudget(1, clock));
    EXPECT_GE(support_.field().size(), 5u) << "enough to recognise the scene, in frame " << i;
    EXPECT_NEAR(moved({270, 120}).x, 270 + x, 0.5) << i;
  }
}

TEST_F(Support, NewPointsHaveCoordinatesOfTheFirstFrame) {
  show_scene({});
  // Slowly to the right: new points at the left edge get coordinates left of the first picture.
  for (int i = 1; i <= 70; ++i) show_scene({0.5 * i, 0});
  const cv::Point2d entered(-25, 120);
  EXPECT_NEAR(moved(entered).x, 10, 0.5);
  EXPECT_NEAR(moved(entered).y, 120, 0.5);
  EXPECT_EQ(support_.chart(), 0);
}

TEST_F(Support, AnotherSceneGetsItsOwnChartAndTheFirstComesBack) {
  show_scene({});
  for (int i = 1; i <= 15; ++i) show_scene({});
  const MovingScene other({320, 240}, 9);
  for (int i = 0; i < 40; ++i) {
    show(other.render({}));
    if (i > 0 && i < 20) {
      EXPECT_FALSE(support_.field().map_at({160, 120}, 0, 0.5, {})) << i;
    }
  }
  EXPECT_EQ(support_.chart(), 1);
  EXPECT_TRUE(support_.field().map_at({160, 120}, 1, 0.5, {}));
  for (int i = 0; i < 3; ++i) show_scene({});
  const auto back = support_.field().map_at({160, 120}, 0, 0.5, {});
  ASSERT_TRUE(back);
  EXPECT_NEAR(back({160, 120}).x, 160, 0.3);
}

TEST_F(Support, PointsThatAreHiddenInAFrameLeaveItsField) {
  for (int i = 0; i <= 20; ++i) show_scene({1.0 * i, 0});
  const auto before = support_.field().size();
  ASSERT_GT(before, 120u);
  // The patches still fit in a shadow over two fifths of the picture. Only the decision on visibility hides them.
  tuning_.weigh_darker = -100;
  cv::Mat bgr = scene_.render({21, 0});
  bgr.colRange(0, 128) -= cv::Scalar::all(30);
  show(bgr);
  EXPECT_LT(support_.field().size(), before * 7 / 10);
  EXPECT_GT(support_.field().size(), before / 2);
}

TEST_F(Support, PointsThatAreFoundTogetherGetTheirMapInThatFrame) {
  tuning_.min_matches = 1e6;  // the picture as a whole is not recognised
  for (int i = 0; i <= 8; ++i) show_scene({});
  const auto before = support_.field().size();
  ASSERT_GT(before, 160u);
  for (int i = 0; i < 4; ++i) show(cv::Mat(240, 320, CV_8UC3, cv::Scalar(3, 2, 4)));
  ASSERT_EQ(support_.field().size(), 0u);
  // Each is aligned where it was. While they learn, none is visible without a map, which the others make.
  show_scene({1, 0.5});
  EXPECT_GT(support_.field().size(), before * 9 / 10);
  EXPECT_NEAR(moved({160, 120}).x, 161, 0.2);
  EXPECT_NEAR(moved({160, 120}).y, 120.5, 0.2);
}

TEST_F(Support, IsFoundAgainAfterALongTimeAndAnyRotation) {
  for (int i = 0; i <= 15; ++i) show_scene({});
  for (int i = 0; i < 12 * 25; ++i) show(cv::Mat(240, 320, CV_8UC3, cv::Scalar(3, 2, 4)));
  EXPECT_EQ(support_.chart(), 0) << "no chart begins in the dark";
  EXPECT_EQ(support_.field().size(), 0u);
  cv::Mat turned;  // by 80° about the middle, scaled by 0.8
  const cv::Mat turn = cv::getRotationMatrix2D({160, 120}, 80, 0.8);
  cv::warpAffine(scene_.render({}), turned, turn, {320, 240}, cv::INTER_LINEAR, cv::BORDER_REFLECT_101);
  show(turned);
  EXPECT_EQ(support_.chart(), 0);
  const auto map = support_.field().map_at({130, 110}, 0, 0.5, {});
  ASSERT_TRUE(map);
  const cv::Mat_<double> to = turn * (cv::Mat_<double>(3, 1) << 130, 110, 1);
  EXPECT_LT(cv::norm(map({130, 110}) - cv::Point2d(to(0), to(1))), 0.5);
}

TEST_F(Support, AChartMadeMeanwhileOnTheSameTissueMergesIntoTheFirst) {
  for (int i = 0; i <= 15; ++i) show_scene({});
  cv::Mat turned;
  const cv::Mat turn = cv::getRotationMatrix2D({160, 120}, 60, 1);
  cv::warpAffine(scene_.render({}), turned, turn, {320, 240}, cv::INTER_LINEAR, cv::BORDER_REFLECT_101);
  const MovingScene other({320, 240}, 9);
  for (int i = 0; i < 45; ++i) show(other.render({}));
  ASSERT_EQ(support_.chart(), 1);
  for (int i = 0; i < 5; ++i) show(turned);
  EXPECT_EQ(support_.chart(), 0);
  EXPECT_FALSE(support_.field().map_at({160, 120}, 1, 0.5, {}));
  EXPECT_TRUE(support_.field().map_at({160, 120}, 0, 0.5, {}));
}

TEST_F(Support, PastTheBudgetAFewTakeTurnsAcrossThePicture) {
  show_scene({});
  const auto all = support_.size();
  ASSERT_GT(all, 60u);
  std::int64_t now = 0;
  const FrameBudget::Clock clock = [&now] { return ++now; };
  for (int i = 1; i <= 12; ++i) {
    show(scene_.render({0.5 * i, 0.25 * i}), FrameBudget(1, clock));
    EXPECT_EQ(support_.size(), all);
    EXPECT_LE(support_.field().size(), 24u) << i;
    EXPECT_GE(support_.field().size(), 20u) << i;
    for (const cv::Point2d p : {cv::Point2d(50, 50), {160, 120}, {280, 200}}) {
      EXPECT_NEAR(moved(p).x, p.x + 0.5 * i, 0.3) << i;
      EXPECT_NEAR(moved(p).y, p.y + 0.25 * i, 0.3) << i;
    }
  }
  // By now 288 of 300 have been aligned; 3 % have left the picture.
  show_scene({6.5, 3.25});
  EXPECT_GE(support_.field().size(), all * 9 / 10);
}

TEST_F(Support, FindsNothingInAFlatPicture) {
  show(cv::Mat(240, 320, CV_8UC3, cv::Scalar(80, 90, 120)));
  EXPECT_EQ(support_.size(), 0u);
  show_scene({});
  EXPECT_GT(support_.size(), 60u);
}

}  // namespace
}  // namespace csd
