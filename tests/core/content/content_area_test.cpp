// SPDX-License-Identifier: LGPL-2.1-or-later
#include "content/content_area.h"

#include <gtest/gtest.h>

#include <opencv2/imgproc.hpp>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "core/clips.h"
#include "detect/shi_tomasi.h"

namespace {

constexpr std::int64_t frame_time = 40'000'000;
constexpr int patch = 21;

/// Smooth random texture around 120, larger than a frame, so that a window can move over it.
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

TEST(ContentArea, ARoundFieldIsKnownFromTheFirstFrame) {
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
      if (!finder.contains(cv::Point2d(x, y))) {
        const cv::Rect covered(x - patch / 2, y - patch / 2, patch, patch);
        EXPECT_EQ(cv::countNonZero(field(covered)), patch * patch) << x << ',' << y;
      }
    }
  }
}

TEST(ContentArea, FindsThePillarBoxAndNothingElse) {
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

TEST(ContentArea, ADarkToolThatComesInIsNotBorder) {
  const cv::Mat all = texture();
  csd::ContentAreaFinder finder;
  for (int i = 0; i < 50; ++i) {
    cv::Mat frame = window(all, i);
    if (i >= 25 && i < 50) frame(cv::Rect(0, 200, 200, 60)).setTo(18);
    finder.update(frame, i * frame_time, patch);
  }
  EXPECT_FALSE(finder.contains({60, 230}));
}

TEST(ContentArea, FindsTextOverMovingTexture) {
  const cv::Mat all = texture();
  csd::ContentAreaFinder finder;
  for (int i = 0; i < 75; ++i) {
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

TEST(ContentArea, AStillPictureHasNoGraphics) {
  cv::Mat frame = texture()(cv::Rect(0, 0, 640, 480)).clone();
  cv::putText(frame, "LASER OFF", {240, 250}, cv::FONT_HERSHEY_SIMPLEX, 1, cv::Scalar(235), 2);
  csd::ContentAreaFinder finder;
  for (int i = 0; i < 75; ++i) finder.update(frame, i * frame_time, patch);
  EXPECT_EQ(cv::countNonZero(finder.forbidden()), 0);
}

TEST(ContentArea, AcceptsTinyPictures) {
  for (const int side : {1, 2, 5, 16}) {
    csd::ContentAreaFinder finder;
    for (int i = 0; i < 30; ++i) finder.update(cv::Mat(side, side, CV_8UC1, cv::Scalar(90)), i * frame_time, 9);
    EXPECT_EQ(cv::countNonZero(finder.forbidden()), 0) << side;
  }
}

/// What a real clip shows after 2.5 s. The places were picked by hand in that frame.
struct Clip {
  std::string name;
  cv::Rect border;  // where a patch touches border or graphics; if empty, wherever a tenth of it is dark
  std::vector<cv::Point2d> on, off;
};

int on_border(const Clip &clip, const cv::Mat &luma, const cv::Mat &forbidden) {
  const cv::Mat allowed = forbidden.empty() ? cv::Mat(luma.size(), CV_8UC1, cv::Scalar(255)) : cv::Mat(forbidden == 0);
  csd::Candidates corners = csd::find_shi_tomasi(luma, allowed, 7, patch / 2.0);
  corners.resize(std::min<std::size_t>(corners.size(), 50));
  int count = 0;
  for (const csd::Candidate &c : corners) {
    const cv::Point p(cvRound(c.at.x), cvRound(c.at.y));
    const cv::Rect around = cv::Rect(p.x - patch / 2, p.y - patch / 2, patch, patch) & cv::Rect({}, luma.size());
    const bool dark = cv::countNonZero(luma(around) < 28) > around.area() / 10;
    count += (clip.border.empty() ? dark : clip.border.contains(p)) ? 1 : 0;
  }
  return count;
}

TEST(ContentArea, FindsBorderAndTextStripOfClips) {
  const cv::Rect strip(0, 492, 340, 20);
  const std::vector<cv::Point2d> text{{200, 503}, {250, 506}, {320, 507}};
  const std::vector<Clip> clips{
      {"abdomen.mkv", strip, text, {{100, 250}, {400, 350}, {300, 100}}},
      {"cutting.mp4", strip, text, {{100, 350}, {150, 100}, {550, 60}}},
      {"smoke.mp4", {}, {{5, 128}, {250, 128}, {12, 128}, {239, 128}, {34, 20}}, {{128, 128}, {128, 60}, {200, 128}}}};
  for (const Clip &clip : clips) {
    auto video = csd::test::open_clip(clip.name);
    if (!video.isOpened()) GTEST_SKIP() << "no clips: set CSDTRACK_CLIPS";
    csd::ContentAreaFinder finder;
    cv::Mat bgr, luma;
    const double fps = video.get(cv::CAP_PROP_FPS);
    for (int i = 0; i < 2.5 * fps && video.read(bgr); ++i) {
      cv::cvtColor(bgr, luma, cv::COLOR_BGR2GRAY);
      finder.update(luma, static_cast<std::int64_t>(i * 1e9 / fps), patch);
    }
    for (const cv::Point2d &p : clip.on) EXPECT_TRUE(finder.contains(p)) << clip.name << p;
    for (const cv::Point2d &p : clip.off) EXPECT_FALSE(finder.contains(p)) << clip.name << p;
    EXPECT_GT(on_border(clip, luma, {}), 0) << clip.name;
    EXPECT_LE(on_border(clip, luma, finder.forbidden()), 1) << clip.name;
  }
}

}  // namespace
