// SPDX-License-Identifier: LGPL-2.1-or-later
#include "programs/label_view.h"

#include <gtest/gtest.h>

namespace csd::programs {
namespace {

TEST(LabelView, ShowsAllOfASmallPictureUnscaled) {
  const LabelView view = LabelView::whole({640, 480}, {1500, 850});
  EXPECT_EQ(view.screen, cv::Size(640, 480));
  EXPECT_EQ(view.to_picture({17, 4}), cv::Point2d(17, 4));
}

TEST(LabelView, ShrinksALargePictureWithPixelCentresAtIntegers) {
  const LabelView view = LabelView::whole({1920, 1080}, {960, 850});
  EXPECT_EQ(view.screen, cv::Size(960, 540));
  // A screen pixel covers 2 × 2 of the picture's pixels: its centre lies between them.
  EXPECT_EQ(view.to_picture({0, 0}), cv::Point2d(0.5, 0.5));
  EXPECT_EQ(view.to_picture({100, 10}), cv::Point2d(200.5, 20.5));
  EXPECT_EQ(view.to_screen({200.5, 20.5}), cv::Point2d(100, 10));
}

TEST(LabelView, ZoomKeepsThePlaceUnderTheMouse) {
  LabelView view = LabelView::whole({640, 480}, {1500, 850});
  view.zoom({300, 200}, 4);
  EXPECT_EQ(view.to_picture({300, 200}), cv::Point2d(300, 200));
  EXPECT_EQ(view.to_picture({301, 200}), cv::Point2d(300.25, 200)) << "a quarter of a pixel";
  EXPECT_EQ(view.to_screen({301, 199}), cv::Point2d(304, 196));
}

/// A black picture with one white pixel.
cv::Mat dot(cv::Point at) {
  cv::Mat picture = cv::Mat::zeros(240, 320, CV_8UC3);
  picture.at<cv::Vec3b>(at) = {255, 0, 0};
  return picture;
}

TEST(LabelView, DrawsWhatAClickWouldHit) {
  LabelView view = LabelView::whole({320, 240}, {1500, 850});
  const LabelSession session(50);
  const cv::Mat picture = dot({100, 50});
  EXPECT_EQ(draw_label_window(view, picture, picture, session, {0, 0}, "").at<cv::Vec3b>(50, 100),
            cv::Vec3b(255, 0, 0));
  view.zoom({100, 50}, 4);
  const cv::Mat zoomed = draw_label_window(view, picture, picture, session, {0, 0}, "");
  int dots = 0;
  for (int y = 0; y < 240; ++y)
    for (int x = 0; x < 320; ++x) {
      if (zoomed.at<cv::Vec3b>(y, x) != cv::Vec3b(255, 0, 0)) continue;
      ++dots;
      const cv::Point2d hit = view.to_picture({x, y});
      EXPECT_TRUE(std::abs(hit.x - 100) < 0.6 && std::abs(hit.y - 50) < 0.6) << x << "," << y;
    }
  EXPECT_EQ(dots, 16);
}

TEST(LabelView, MarksLabelsAndShowsWhatToLookFor) {
  const LabelView view = LabelView::whole({320, 240}, {1500, 850});
  LabelSession session(50);
  session.place({60, 60});
  session.place({200, 100});
  const cv::Mat first = dot({60, 60}), frame = cv::Mat::zeros(240, 320, CV_8UC3);
  const cv::Vec3b green(0, 255, 0);
  EXPECT_EQ(draw_label_window(view, frame, first, session, {0, 0}, "").at<cv::Vec3b>(60, 66), green);
  session.done_choosing();
  const cv::Mat asking = draw_label_window(view, frame, first, session, {0, 0}, "");
  EXPECT_NE(asking.at<cv::Vec3b>(60, 66), green) << "labels of frame 0 are not those of frame 50";
  // Point 0 as in frame 0: the middle of the lower square at the right.
  EXPECT_EQ(asking.at<cv::Vec3b>(248 + 120, 320 + 8 + 120), cv::Vec3b(255, 0, 0));
}

}  // namespace
}  // namespace csd::programs
