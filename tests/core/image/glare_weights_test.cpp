// SPDX-License-Identifier: LGPL-2.1-or-later
#include "image/glare_weights.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/picture.h"
#include "image/work_frame.h"

namespace csd {
namespace {

GlareWeights weights_of(const cv::Mat &bgr, const cv::Mat &forbidden = {}, test::Layout layout = test::Layout::bgr) {
  const auto packed = test::pack(bgr, layout);
  WorkFrame frame;
  frame.load(packed.view);
  GlareWeights weights;
  weights.build(frame, forbidden);
  return weights;
}

const cv::Scalar tissue(60, 70, 160), pale(190, 200, 215), white(250, 250, 250);
const cv::Size vga(640, 480);

int masked(const GlareWeights &weights) {
  return static_cast<int>(weights.level(0).total()) - cv::countNonZero(weights.level(0));
}

TEST(GlareWeights, HighlightAndItsRim) {
  cv::Mat bgr(vga, CV_8UC3, tissue);
  bgr({300, 200, 9, 7}).setTo(white);
  const auto weights = weights_of(bgr);
  // One pixel more by the smoothing (a quarter of a step of 190 is above .2·(250 − 60) = 38, 3/16 aren't: the ends of
  // each side stay out), and two by the dilation, which is a square.
  EXPECT_EQ(masked(weights), 15 * 13 - 4 * 3);
  EXPECT_EQ(weights.level(0).at<std::uint8_t>(200, 297), 0);
  EXPECT_EQ(weights.level(0).at<std::uint8_t>(200, 296), 255);
  EXPECT_EQ(weights.level(0).at<std::uint8_t>(209, 303), 0);
  EXPECT_EQ(weights.level(0).at<std::uint8_t>(210, 303), 255);
}

TEST(GlareWeights, PaleTissueAndGradientsOfLightAreNoHighlight) {
  EXPECT_EQ(masked(weights_of(cv::Mat(vga, CV_8UC3, pale))), 0);
  cv::Mat lit(vga, CV_8UC3);
  for (int y = 0; y < lit.rows; ++y)
    for (int x = 0; x < lit.cols; ++x) {
      const double light = std::exp(-(std::pow(x - 300., 2) + std::pow(y - 200., 2)) / (2 * 150. * 150));
      for (int k = 0; k < 3; ++k) lit.ptr(y)[3 * x + k] = static_cast<std::uint8_t>((20 + 225 * light) * pale[k] / 215);
    }
  EXPECT_EQ(masked(weights_of(lit)), 0);
}

TEST(GlareWeights, ColouredLightIsNoHighlight) {
  cv::Mat bgr(vga, CV_8UC3, tissue);
  bgr({300, 200, 9, 7}).setTo(cv::Scalar(60, 90, 255));
  EXPECT_EQ(masked(weights_of(bgr)), 0);
}

TEST(GlareWeights, GrayHasLumaAlone) {
  cv::Mat bgr(vga, CV_8UC3, tissue);
  bgr({300, 200, 9, 7}).setTo(cv::Scalar(60, 140, 255));  // Y 159 of 235 on 100
  EXPECT_EQ(masked(weights_of(bgr)), 0);
  EXPECT_GT(masked(weights_of(bgr, {}, test::Layout::gray8)), 9 * 7);
}

TEST(GlareWeights, ForbiddenWeighsNothingAndDoesNotDarkenTheBackground) {
  // A dark border takes three quarters of the cells at the corner of pale tissue.
  cv::Mat bgr(vga, CV_8UC3, cv::Scalar(0, 0, 0)), forbidden(vga, CV_8UC1, cv::Scalar(255));
  const cv::Rect field(160, 120, 320, 240);
  bgr(field).setTo(pale);
  forbidden(field).setTo(0);
  const auto weights = weights_of(bgr, forbidden);
  EXPECT_EQ(cv::norm(weights.level(0), 255 - forbidden, cv::NORM_INF), 0);
}

TEST(GlareWeights, CoarserLevelsAreMeansOfWhatTheyCover) {
  for (const cv::Size size : {cv::Size(640, 480), cv::Size(161, 117), cv::Size(16, 16), cv::Size(17, 33)}) {
    cv::Mat bgr(size, CV_8UC3, tissue), forbidden(size, CV_8UC1);
    cv::RNG(3).fill(forbidden, cv::RNG::UNIFORM, 0, 2);
    forbidden *= 255;
    const auto weights = weights_of(bgr, forbidden);
    for (int l = 1; l < Pyramid::levels; ++l) {
      const cv::Mat &fine = weights.level(l - 1), &mean = weights.level(l);
      ASSERT_EQ(mean.size(), cv::Size((fine.cols + 1) / 2, (fine.rows + 1) / 2));
      const auto reflect = [](int i, int n) { return n == 1 ? 0 : i < 0 ? -i : i >= n ? 2 * n - 2 - i : i; };
      for (int y = 0; y < mean.rows; ++y)
        for (int x = 0; x < mean.cols; ++x) {
          double sum = 0;
          for (int j = -1; j <= 1; ++j)
            for (int i = -1; i <= 1; ++i)
              sum += (2 - std::abs(i)) * (2 - std::abs(j)) / 16. *
                     fine.ptr(reflect(2 * y + j, fine.rows))[reflect(2 * x + i, fine.cols)];
          ASSERT_EQ(mean.ptr(y)[x], std::floor(sum + .5)) << l << ": " << x << "," << y;
        }
    }
  }
}

}  // namespace
}  // namespace csd
