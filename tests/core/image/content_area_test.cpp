// SPDX-License-Identifier: LGPL-2.1-or-later
#include "image/content_area.h"

#include <gtest/gtest.h>

#include <opencv2/imgproc.hpp>
#include <opencv2/videoio.hpp>

#include <cmath>
#include <cstdlib>
#include <string>

#include "detect/detect.h"

namespace {

constexpr std::int64_t frame_time = 40'000'000;
constexpr int patch = 21;

/// Smooth random texture around 120, larger than a frame, to move a window over.
cv::Mat texture() {
  cv::Mat noise(600, 800, CV_32FC1), result;
  cv::RNG rng(7);
  rng.fill(noise, cv::RNG::NORMAL, 0, 1);
  cv::GaussianBlur(noise, noise, {}, 3);
  noise.convertTo(result, CV_8U, 240, 120);
  return result;
}

cv::Mat window(const cv::Mat &all, int frame) {
  const int dx = 40 + static_cast<int>(std::lround(30 * std::sin(frame * 0.2)));
  return all(cv::Rect(dx, 40, 640, 480)).clone();
}

TEST(ContentArea, RoundFieldIsKnownOnTheFirstFrame) {
  cv::Mat field = cv::Mat::zeros(480, 640, CV_8UC1);
  cv::circle(field, {320, 240}, 200, cv::Scalar(255), cv::FILLED);
  cv::Mat frame(480, 640, CV_8UC1, cv::Scalar(20));
  texture()(cv::Rect(0, 0, 640, 480)).copyTo(frame, field);
  csd::ContentAreaFinder finder;
  finder.update(frame, 0, patch);
  EXPECT_TRUE(finder.changed());
  for (int y = 0; y < 480; y += 4) {
    for (int x = 0; x < 640; x += 4) {
      const double r = std::hypot(x - 320, y - 240);
      if (r > 200 - 10) {
        EXPECT_TRUE(finder.contains(cv::Point2d(x, y))) << x << ',' << y;
      }
      if (r < 200 - 30) {
        EXPECT_FALSE(finder.contains(cv::Point2d(x, y))) << x << ',' << y;
      }
    }
  }
}

TEST(ContentArea, PillarBoxAndNothingElse) {
  cv::Mat frame = texture()(cv::Rect(0, 0, 640, 480)).clone();
  frame.colRange(0, 80).setTo(16);
  csd::ContentAreaFinder finder;
  finder.update(frame, 0, patch);
  EXPECT_TRUE(finder.contains({89, 240}));
  EXPECT_FALSE(finder.contains({110, 240}));
  EXPECT_FALSE(finder.contains({635, 240}));
}

TEST(ContentArea, BlackIsAllBorderUntilThereIsLight) {
  csd::ContentAreaFinder finder;
  finder.update(cv::Mat(480, 640, CV_8UC1, cv::Scalar(16)), 0, patch);
  EXPECT_EQ(cv::countNonZero(finder.forbidden()), 640 * 480);
  finder.update(texture()(cv::Rect(0, 0, 640, 480)).clone(), 2 * frame_time, patch);
  EXPECT_EQ(cv::countNonZero(finder.forbidden()), 0);
}

TEST(ContentArea, DarkToolThatComesInIsNoBorder) {
  const cv::Mat all = texture();
  csd::ContentAreaFinder finder;
  for (int i = 0; i < 50; ++i) {
    cv::Mat frame = window(all, i);
    if (i >= 25 && i < 50) frame(cv::Rect(0, 200, 200, 60)).setTo(18);
    finder.update(frame, i * frame_time, patch);
  }
  EXPECT_FALSE(finder.contains({60, 230}));
}

TEST(ContentArea, TextOverMovingTexture) {
  const cv::Mat all = texture();
  csd::ContentAreaFinder finder;
  for (int i = 0; i < 60; ++i) {
    cv::Mat frame = window(all, i);
    cv::putText(frame, "LASER OFF", {240, 250}, cv::FONT_HERSHEY_SIMPLEX, 1, cv::Scalar(235), 2);
    finder.update(frame, i * frame_time, patch);
    if (i == 5) {
      EXPECT_FALSE(finder.contains({250, 240}));
    }
  }
  EXPECT_TRUE(finder.contains({250, 248}));
  EXPECT_FALSE(finder.contains({320, 120}));
  EXPECT_LT(cv::countNonZero(finder.forbidden()), 640 * 480 / 10);
}

TEST(ContentArea, StaticPictureHasNoGraphics) {
  cv::Mat frame = texture()(cv::Rect(0, 0, 640, 480)).clone();
  cv::putText(frame, "LASER OFF", {240, 250}, cv::FONT_HERSHEY_SIMPLEX, 1, cv::Scalar(235), 2);
  csd::ContentAreaFinder finder;
  for (int i = 0; i < 75; ++i) finder.update(frame, i * frame_time, patch);
  EXPECT_EQ(cv::countNonZero(finder.forbidden()), 0);
}

TEST(ContentArea, TinyPictures) {
  for (const int side : {1, 2, 5, 16}) {
    csd::ContentAreaFinder finder;
    for (int i = 0; i < 30; ++i) finder.update(cv::Mat(side, side, CV_8UC1, cv::Scalar(90)), i * frame_time, 9);
    EXPECT_EQ(cv::countNonZero(finder.forbidden()), 0) << side;
  }
}

/// Features in the strip at the bottom of a real clip two seconds in.
TEST(ContentArea, TextStripOfClips) {
  const char *clips = std::getenv("CSDTRACK_CLIPS");
  for (const std::string name : {"abdomen.mkv", "cutting.mp4"}) {
    cv::VideoCapture video((clips != nullptr ? clips : "../shared/clips") + ("/" + name));
    if (!video.isOpened()) GTEST_SKIP() << "no clips: set CSDTRACK_CLIPS";
    csd::ContentAreaFinder finder;
    cv::Mat bgr, luma;
    const double fps = video.get(cv::CAP_PROP_FPS);
    for (int i = 0; i < 2 * fps && video.read(bgr); ++i) {
      cv::cvtColor(bgr, luma, cv::COLOR_BGR2GRAY);
      finder.update(luma, static_cast<std::int64_t>(i * 1e9 / fps), patch);
    }
    int on_strip = 0;
    for (const cv::Point2d &p : csd::detect(luma, {}, finder.forbidden(), {patch, 50})) {
      on_strip += p.x < 340 && p.y > 500 - patch / 2 ? 1 : 0;  // the strip is 340×12 at the lower left
    }
    EXPECT_LE(on_strip, 1) << name;
  }
}

}  // namespace
