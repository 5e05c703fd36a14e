// SPDX-License-Identifier: LGPL-2.1-or-later
#include "content/burnt_in.h"

#include <gtest/gtest.h>

#include <opencv2/imgproc.hpp>

#include <cmath>

#include "noisy_texture.h"

namespace {

constexpr double dt = 0.16;  // s: every fourth frame at 25 a second
constexpr double sigma = 2;  // grey levels, of noise
const cv::Size size(640, 480);

/// A window that swings over the texture; `amplitude` in pixels.
cv::Mat tissue(double t, double amplitude) {
  static const cv::Mat texture = csd::blob_texture({800, 600});
  const auto move = [&](double rate) { return 50 + static_cast<int>(std::lround(amplitude * std::sin(rate * t))); };
  return texture(cv::Rect(move(4.9), move(3.7), size.width, size.height)).clone();
}

constexpr char text[] = "LASER OFF";
const cv::Point text_at(220, 250);

void write(cv::Mat &picture) {
  cv::putText(picture, text, text_at, cv::FONT_HERSHEY_SIMPLEX, 1, cv::Scalar(235), 2);
}

/// The text's mask, 255, at the picture's size.
cv::Mat written() {
  cv::Mat result = cv::Mat::zeros(size, CV_8UC1);
  cv::putText(result, text, text_at, cv::FONT_HERSHEY_SIMPLEX, 1, cv::Scalar(255), 2);
  return result;
}

cv::Mat grown(const cv::Mat &mask, int radius) {
  cv::Mat result;
  cv::dilate(mask, result, cv::getStructuringElement(cv::MORPH_RECT, {2 * radius + 1, 2 * radius + 1}));
  return result;
}

TEST(BurntIn, FindsTextOverMovingTextureAndNothingElse) {
  cv::RNG rng(5);
  csd::BurntIn graphics;
  bool changed = false;
  for (double t = 0; t < 5; t += dt) {
    cv::Mat picture = tissue(t, 25);
    write(picture);
    changed |= graphics.update(csd::with_noise(picture, sigma, rng), dt);
    cv::Mat found;
    cv::resize(graphics.mask(), found, size, 0, 0, cv::INTER_NEAREST);
    EXPECT_EQ(changed, cv::countNonZero(found) > 0) << t;
    // In the half-size copy, an edge shows up to two pixels from the stroke.
    EXPECT_EQ(cv::countNonZero(found & ~grown(written(), 4)), 0) << t;
    if (t < 1) {
      EXPECT_FALSE(changed) << t;
    }
    if (t >= 3) {
      const int strokes = cv::countNonZero(written());
      EXPECT_GE(cv::countNonZero(written() & grown(found, 4)), 0.95 * strokes) << t;
    }
  }
}

TEST(BurntIn, ForgetsTextThatGoes) {
  cv::RNG rng(5);
  csd::BurntIn graphics;
  for (double t = 0; t < 9; t += dt) {
    cv::Mat picture = tissue(t, 25);
    if (t < 4) write(picture);
    graphics.update(csd::with_noise(picture, sigma, rng), dt);
    if (t >= 3 && t < 4) {
      ASSERT_GT(cv::countNonZero(graphics.mask()), 0);
    }
  }
  EXPECT_EQ(cv::countNonZero(graphics.mask()), 0);
}

// The texture has sharp, still edges, as graphics do. A tool that moves beside them proves nothing.
TEST(BurntIn, IgnoresStillTextureBesideAMovingTool) {
  cv::RNG rng(5);
  csd::BurntIn graphics;
  for (double t = 0; t < 8; t += dt) {
    cv::Mat picture = tissue(0, 0);
    const int tip = 300 + static_cast<int>(std::lround(60 * std::sin(3.1 * t)));
    const int top = 210 + static_cast<int>(std::lround(12 * std::sin(4.3 * t)));
    cv::rectangle(picture, {0, top}, {tip, top + 40}, cv::Scalar(190), cv::FILLED);
    for (int x = tip % 24; x < tip; x += 24) cv::line(picture, {x, top}, {x, top + 40}, cv::Scalar(90), 3);
    EXPECT_FALSE(graphics.update(csd::with_noise(picture, sigma, rng), dt)) << t;
  }
  EXPECT_EQ(cv::countNonZero(graphics.mask()), 0);
}

// Around a line of text, motion lies within an eighth of the picture's height. Around letters in a filled box it lies
// only beyond the box.
TEST(BurntIn, FindsLettersInAFilledBox) {
  cv::RNG rng(5);
  csd::BurntIn graphics;
  const cv::Rect box(200, 160, 240, 90);
  const auto letters = [&](cv::Mat &picture, double grey) {
    for (int y = box.y + 24; y < box.br().y; y += 26) {
      cv::putText(picture, "PATIENT 0815", {box.x + 8, y}, cv::FONT_HERSHEY_SIMPLEX, 0.7, cv::Scalar(grey), 2);
    }
  };
  for (double t = 0; t < 5; t += dt) {
    cv::Mat picture = tissue(t, 25);
    cv::rectangle(picture, box, cv::Scalar(60), cv::FILLED);
    letters(picture, 235);
    graphics.update(csd::with_noise(picture, sigma, rng), dt);
  }
  cv::Mat found, strokes = cv::Mat::zeros(size, CV_8UC1), inside = strokes.clone();
  cv::resize(graphics.mask(), found, size, 0, 0, cv::INTER_NEAREST);
  letters(strokes, 255);
  inside(box).setTo(255);
  EXPECT_GE(cv::countNonZero(strokes & grown(found, 4)), 0.95 * cv::countNonZero(strokes));
  EXPECT_EQ(cv::countNonZero(found & ~grown(inside, 4)), 0);
}

TEST(BurntIn, FindsNothingInAStillPicture) {
  cv::RNG rng(5);
  csd::BurntIn graphics;
  cv::Mat picture = tissue(0, 0);
  write(picture);
  for (double t = 0; t < 8; t += dt) EXPECT_FALSE(graphics.update(csd::with_noise(picture, sigma, rng), dt)) << t;
  EXPECT_EQ(cv::countNonZero(graphics.mask()), 0);
}

}  // namespace
