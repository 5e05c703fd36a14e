// SPDX-License-Identifier: LGPL-2.1-or-later
#include "content/dark_border.h"

#include <gtest/gtest.h>

#include <opencv2/imgproc.hpp>

#include <string>
#include <vector>

#include "noisy_texture.h"

namespace {

constexpr double dt = 0.04;  // s
constexpr double sigma = 4;  // grey levels
const cv::Size size(640, 480);

/// A picture whose border brightens from 16 on the left to 24 on the right, with texture where `field` is not 0.
cv::Mat endoscope(const cv::Mat &field, cv::RNG &rng, int shift = 0) {
  static const cv::Mat texture = csd::blob_texture({800, 600});
  cv::Mat picture(size, CV_8UC1);
  for (int x = 0; x < size.width; ++x) picture.col(x).setTo(16 + 8.0 * x / (size.width - 1));
  texture(cv::Rect(40 + shift, 40, size.width, size.height)).copyTo(picture, field);
  return csd::with_noise(picture, sigma, rng);
}

/// The mask at the picture's size: 255 on the border.
cv::Mat enlarged(const cv::Mat &mask) {
  cv::Mat result;
  cv::resize(mask, result, size, 0, 0, cv::INTER_NEAREST);
  return result;
}

/// Of the pixels in `wrong`, how far the farthest is from `right`, in pixels of the picture.
double farthest(const cv::Mat &wrong, const cv::Mat &right) {
  if (cv::countNonZero(wrong) == 0) return 0;
  if (cv::countNonZero(right) == 0) return 1e9;
  cv::Mat distance;
  cv::distanceTransform(right == 0, distance, cv::DIST_L2, cv::DIST_MASK_PRECISE, CV_32F);
  double most = 0;
  cv::minMaxLoc(distance, nullptr, &most, nullptr, nullptr, wrong);
  return most;
}

struct Field {
  std::string name;
  cv::Mat lit;  // 255 in the field
};

std::vector<Field> fields() {
  const auto box = [](cv::Rect r) {
    cv::Mat lit = cv::Mat::zeros(size, CV_8UC1);
    lit(r).setTo(255);
    return lit;
  };
  cv::Mat round = cv::Mat::zeros(size, CV_8UC1);
  cv::circle(round, {330, 236}, 210, cv::Scalar(255), cv::FILLED);
  cv::Mat d_shaped = round.clone();
  d_shaped.colRange(0, 200).setTo(0);
  return {{"round", round},
          {"D-shaped", d_shaped},
          {"pillar box", box({82, 0, 476, 480})},
          {"letter box", box({0, 59, 640, 361})},
          {"none", box({0, 0, 640, 480})}};
}

TEST(DarkBorder, AgreesWithTheTrueField) {
  for (const Field &field : fields()) {
    cv::RNG rng(5);
    csd::DarkBorder border;
    for (int i = 0; i < 50; ++i) {
      border.update(endoscope(field.lit, rng, i % 20), dt);
      ASSERT_TRUE(border.lit());
      const double reduced = static_cast<double>(size.height) / border.mask().rows;
      const cv::Mat found = enlarged(border.mask());
      // The border is too small by at most a pixel of the reduced picture, and too large by at most three.
      ASSERT_LE(farthest(~field.lit & ~found, found), 1.5 * reduced) << field.name << " frame " << i;
      ASSERT_LE(farthest(field.lit & found, ~field.lit), 3 * reduced) << field.name << " frame " << i;
    }
  }
}

TEST(DarkBorder, WritingInTheBorderIsBorder) {
  cv::RNG rng(5);
  const Field round = fields()[0];
  cv::Mat picture = endoscope(round.lit, rng);
  cv::putText(picture, "12:04", {10, 40}, cv::FONT_HERSHEY_SIMPLEX, 1, cv::Scalar(235), 3);
  csd::DarkBorder border;
  border.update(picture, dt);
  EXPECT_EQ(cv::countNonZero(~enlarged(border.mask())(cv::Rect(0, 0, 100, 60))), 0);
}

TEST(DarkBorder, AToolAtTheEdgeForHalfASecondIsNotBorder) {
  cv::RNG rng(5);
  const cv::Mat lit(size, CV_8UC1, cv::Scalar(255));
  cv::Mat tool = lit.clone();
  tool(cv::Rect(0, 200, 260, 70)).setTo(0);
  csd::DarkBorder border;
  for (int i = 0; i < 75; ++i) {
    const bool there = i >= 30 && i < 43;
    border.update(endoscope(there ? tool : lit, rng, i % 20), dt);
    ASSERT_EQ(cv::countNonZero(border.mask()), 0) << "frame " << i;
  }
}

// A share with a time constant of 1 s rises above 0.9 after ln 10 = 2.3 s. From 1 − e⁻⁴ it falls below 0.75 after 0.3
// s.
TEST(DarkBorder, DarknessBecomesBorderSlowlyAndLightClearsItSooner) {
  cv::RNG rng(5);
  const cv::Mat lit(size, CV_8UC1, cv::Scalar(255));
  cv::Mat half = lit.clone();
  half.colRange(0, 320).setTo(0);
  csd::DarkBorder border;
  for (int i = 0; i < 10; ++i) border.update(endoscope(lit, rng, i), dt);
  for (double t = dt; t < 4; t += dt) {
    border.update(endoscope(half, rng), dt);
    if (t < 2) {
      ASSERT_EQ(cv::countNonZero(border.mask()), 0) << t;
    }
    if (t > 2.5) {
      ASSERT_EQ(cv::countNonZero(~enlarged(border.mask()).colRange(0, 320)), 0) << t;
    }
  }
  for (double t = dt; t < 0.4; t += dt) border.update(endoscope(lit, rng), dt);
  EXPECT_EQ(cv::countNonZero(border.mask()), 0);
}

TEST(DarkBorder, SwitchesFromBlackToLightAndBack) {
  cv::RNG rng(5);
  const cv::Mat sleeve = cv::Mat::zeros(size, CV_8UC1);
  const Field pillar = fields()[2];
  csd::DarkBorder border;
  EXPECT_TRUE(border.update(endoscope(sleeve, rng), dt));
  for (int i = 0; i < 50; ++i) EXPECT_FALSE(border.update(endoscope(sleeve, rng), dt));
  EXPECT_FALSE(border.lit());
  EXPECT_EQ(cv::countNonZero(border.mask()), static_cast<int>(border.mask().total()));
  EXPECT_TRUE(border.update(endoscope(pillar.lit, rng), dt));
  EXPECT_TRUE(border.lit());
  EXPECT_LE(farthest(pillar.lit & enlarged(border.mask()), ~pillar.lit), 12);
  const cv::Mat known = border.mask().clone();
  for (int i = 0; i < 100; ++i) EXPECT_FALSE(border.update(endoscope(sleeve, rng), dt));
  EXPECT_EQ(cv::norm(known, border.mask(), cv::NORM_INF), 0);
}

}  // namespace
