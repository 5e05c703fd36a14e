// SPDX-License-Identifier: LGPL-2.1-or-later
#include "track/recursive.h"

#include <gtest/gtest.h>

#include "track/moving_scene.h"

namespace csd {
namespace {

cv::Mat gray(const cv::Mat &bgr) {
  cv::Mat out;
  cv::cvtColor(bgr, out, cv::COLOR_BGR2GRAY);
  return out;
}

TEST(RecursiveTracker, FollowsAKnownShift) {
  const MovingScene scene;
  RecursiveTracker tracker;
  tracker.keep(gray(scene.render({0, 0})));
  const std::vector<cv::Point2f> start{{60, 60}, {160, 120}, {250.5f, 180.25f}};
  auto points = start;
  std::vector<unsigned char> found;
  // More than half the window: only the pyramid's upper levels reach that far.
  tracker.track(gray(scene.render({14.3, -9.6})), points, found);
  for (std::size_t i = 0; i < start.size(); ++i) {
    EXPECT_TRUE(found[i]);
    EXPECT_NEAR(points[i].x - start[i].x, 14.3, 0.1);
    EXPECT_NEAR(points[i].y - start[i].y, -9.6, 0.1);
  }
}

TEST(RecursiveTracker, TracksFromThePreviousFrame) {
  const MovingScene scene;
  RecursiveTracker tracker;
  std::vector<cv::Point2f> points{{160, 120}};
  std::vector<unsigned char> found;
  for (int i = 0; i <= 10; ++i) {
    const auto picture = gray(scene.render({2.5 * i, -1.5 * i}));
    if (i > 0) tracker.track(picture, points, found);
    tracker.keep(picture);
  }
  EXPECT_NEAR(points[0].x, 185, 0.5);
  EXPECT_NEAR(points[0].y, 105, 0.5);
}

TEST(RecursiveTracker, WithoutAPreviousFrameNothingIsFound) {
  const MovingScene scene;
  RecursiveTracker tracker;
  std::vector<cv::Point2f> points{{160, 120}};
  std::vector<unsigned char> found;
  const auto picture = gray(scene.render({0, 0}));
  tracker.track(picture, points, found);
  EXPECT_EQ(found, std::vector<unsigned char>{0});
  EXPECT_EQ(points[0], cv::Point2f(160, 120));
  tracker.keep(picture);
  tracker.track(gray(MovingScene({200, 100}).render({0, 0})), points, found);
  EXPECT_EQ(found, std::vector<unsigned char>{0}) << "another frame size";
  tracker.keep(picture);
  tracker.skip();
  tracker.track(picture, points, found);
  EXPECT_EQ(found, std::vector<unsigned char>{0}) << "frame skipped";
  for (const std::size_t count : {1, 0}) {
    tracker.keep(picture);
    std::vector<cv::Point2f> some(count, {160, 120});
    tracker.track(picture, some, found);
    EXPECT_EQ(found, std::vector<unsigned char>(count, 1));
    tracker.track(picture, points, found);
    EXPECT_EQ(found, std::vector<unsigned char>{0}) << "the frame in between was not kept";
  }
}

TEST(RecursiveTracker, FindsNothingInAFlatPicture) {
  const cv::Mat flat(240, 320, CV_8UC1, cv::Scalar(90));
  RecursiveTracker tracker;
  tracker.keep(flat);
  std::vector<cv::Point2f> points{{160, 120}};
  std::vector<unsigned char> found;
  tracker.track(flat, points, found);
  EXPECT_EQ(found[0], 0);
}

}  // namespace
}  // namespace csd
