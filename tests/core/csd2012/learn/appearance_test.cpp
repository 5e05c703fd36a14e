// SPDX-License-Identifier: LGPL-2.1-or-later
#include "csd2012/learn/appearance.h"

#include <gtest/gtest.h>

#include <cmath>

namespace csd {
namespace {

/// A wave of four pixels along x and one along y, each in its own channel.
cv::Mat waves(int side) {
  cv::Mat patch(side, side, CV_8UC3);
  for (int y = 0; y < side; ++y)
    for (int x = 0; x < side; ++x)
      patch.at<cv::Vec3b>(y, x) = {cv::saturate_cast<unsigned char>(100 + 60 * std::cos(CV_PI * x / 2)),
                                   cv::saturate_cast<unsigned char>(100 + 60 * std::cos(CV_PI * y / 2)), 100};
  return patch;
}

TEST(Appearance, AHighlightIsWhiteInsideAndLeavesTheRest) {
  Random random(1);
  double white = 0;
  constexpr int patches = 2000, side = 21;
  for (int i = 0; i < patches; ++i) {
    cv::Mat patch(side, side, CV_8UC3, cv::Scalar(10, 20, 30));
    add_highlight(patch, 1, random);
    int same = 0;
    for (const auto &p : cv::Mat_<cv::Vec3b>(patch)) {
      // All three channels approach 255 by the same share.
      const double share = (p[0] - 10) / 245.0;
      EXPECT_NEAR((p[2] - 30) / 225.0, share, .006);
      white += share > .5;
      same += share == 0;
    }
    // The largest highlight covers an ellipse of 6 px and its slope, 1.5 times as wide.
    EXPECT_GE(same, side * side - CV_PI * 9 * 9);
  }
  // r⁴ < ln 2 is an ellipse of .833·a·b·π. E[a·b] = E[a²]·E[share] = (8 + 28/3)·.65; a part of it lies outside the
  // patch.
  const double all = std::sqrt(std::log(2)) * CV_PI * (4 + 12 + 36) / 3.0 * .65;
  EXPECT_LT(white / patches, all);
  EXPECT_GT(white / patches, .6 * all);
}

TEST(Appearance, AHighlightGrowsWithThePicture) {
  const auto changed = [](double pixel) {
    Random random(3);
    cv::Mat patch(101, 101, CV_8UC3, cv::Scalar::all(0));
    double sum = 0;
    for (int i = 0; i < 50; ++i) {
      patch = cv::Scalar::all(0);
      add_highlight(patch, pixel, random);
      sum += cv::sum(patch)[0];
    }
    return sum;
  };
  EXPECT_NEAR(changed(2) / changed(1), 4, .6);
}

TEST(Appearance, BlurKeepsTheMeanAndRemovesTheWaveAcrossIt) {
  Random random(2);
  int along_x = 0, along_y = 0;
  for (int i = 0; i < 60; ++i) {
    cv::Mat patch = waves(41);
    blur_by_motion(patch, 1, random);
    const cv::Mat inner = patch(cv::Rect(10, 10, 21, 21));
    cv::Scalar mean, deviation;
    cv::meanStdDev(inner, mean, deviation);
    for (int k = 0; k < 3; ++k) EXPECT_NEAR(mean[k], 100, 6);
    EXPECT_EQ(deviation[2], 0);
    // Both waves had a deviation of 42. A blur of 5 to 11 px along one leaves at most sinc(5/4) = .18 of it, and all of
    // the other.
    along_x += deviation[0] < 12 && deviation[1] > 30;
    along_y += deviation[1] < 12 && deviation[0] > 30;
  }
  EXPECT_GT(along_x, 3);
  EXPECT_GT(along_y, 3);
}

TEST(Appearance, CompressionMovesACoefficientByAtMostHalfAStep) {
  Random random(4);
  double largest = 0;
  for (int i = 0; i < 200; ++i) {
    cv::Mat patch(21, 21, CV_8UC3), before;
    for (auto &p : cv::Mat_<cv::Vec3b>(patch))
      for (int k = 0; k < 3; ++k) p[k] = static_cast<unsigned char>(60 + random.below(140));
    patch.copyTo(before);
    compress(patch, random);
    // The cosine transform is orthonormal: an error of up to step/2 in 64 coefficients is a deviation of step/√12 a
    // pixel.
    const double error = cv::norm(patch, before, cv::NORM_L2) / std::sqrt(3.0 * 21 * 21);
    EXPECT_LT(error, codec_step[1] / std::sqrt(12) * 1.15);
    EXPECT_GT(error, codec_step[0] / std::sqrt(12) * .85);
    largest = std::max(largest, error);
  }
  EXPECT_GT(largest, codec_step[1] / std::sqrt(12) * .9);
}

TEST(Appearance, CompressionKeepsAFlatPatchAndFlattensAFaintOne) {
  Random random(5);
  cv::Mat even(21, 33, CV_8UC3, cv::Scalar(0, 128, 255));
  compress(even, random);
  for (const auto &p : cv::Mat_<cv::Vec3b>(even)) {
    EXPECT_NEAR(p[0], 0, 2);  // the mean is an eighth of its coefficient, which is rounded to a step
    EXPECT_NEAR(p[1], 128, 2);
    EXPECT_NEAR(p[2], 255, 2);
  }
  cv::Mat faint(24, 24, CV_8UC3, cv::Scalar::all(100));
  faint.at<cv::Vec3b>(12, 12) = {104, 104, 104};  // all its coefficients stay below 4.5
  compress(faint, random);
  EXPECT_LE(std::abs(faint.at<cv::Vec3b>(12, 12)[0] - faint.at<cv::Vec3b>(12, 11)[0]), 1);
}

TEST(Appearance, TheSameSeedGivesTheSamePatch) {
  const auto changed = [](std::uint64_t seed) {
    Random random(seed);
    cv::Mat patch = waves(21);
    add_highlight(patch, 1, random);
    blur_by_motion(patch, 1, random);
    compress(patch, random);
    return patch;
  };
  EXPECT_EQ(cv::norm(changed(1), changed(1), cv::NORM_L1), 0);
  EXPECT_GT(cv::norm(changed(1), changed(2), cv::NORM_L1), 0);
  Random random(1);
  cv::Mat gray = cv::Mat::zeros(9, 9, CV_8UC1);
  EXPECT_THROW(add_highlight(gray, 1, random), cv::Exception);
  EXPECT_THROW(blur_by_motion(gray, 1, random), cv::Exception);
  EXPECT_THROW(compress(gray, random), cv::Exception);
}

}  // namespace
}  // namespace csd
