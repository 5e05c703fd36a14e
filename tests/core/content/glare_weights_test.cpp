// SPDX-License-Identifier: LGPL-2.1-or-later
#include "content/glare_weights.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <stdexcept>
#include <string>
#include <vector>

#include "core/clips.h"
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

const cv::Scalar tissue(60, 70, 160), pale(190, 200, 215), white(240, 240, 240);
const cv::Size vga(640, 480);

int masked(const GlareWeights &weights) {
  return cv::countNonZero(weights.level(0) == GlareWeights::highlight);
}

TEST(GlareWeights, MasksAHighlightAndItsRim) {
  cv::Mat bgr(vga, CV_8UC3, tissue);
  bgr({300, 200, 9, 7}).setTo(white);
  const auto weights = weights_of(bgr);
  // Smoothing adds no pixels (a quarter of a step of 180 is below .4·(250 − 60) = 76) and removes none (a corner keeps
  // 9/16). The dilation, a square, adds two on each side.
  EXPECT_EQ(masked(weights), 13 * 11);
  EXPECT_EQ(weights.level(0).at<std::uint8_t>(200, 298), GlareWeights::highlight);
  EXPECT_EQ(weights.level(0).at<std::uint8_t>(200, 297), 255);
  EXPECT_EQ(weights.level(0).at<std::uint8_t>(208, 303), GlareWeights::highlight);
  EXPECT_EQ(weights.level(0).at<std::uint8_t>(209, 303), 255);
}

TEST(GlareWeights, PaleTissueAndGradientsOfLightAreNotHighlights) {
  EXPECT_EQ(masked(weights_of(cv::Mat(vga, CV_8UC3, pale))), 0);
  cv::Mat lit(vga, CV_8UC3);
  for (int y = 0; y < lit.rows; ++y)
    for (int x = 0; x < lit.cols; ++x) {
      const double light = std::exp(-(std::pow(x - 300., 2) + std::pow(y - 200., 2)) / (2 * 150. * 150));
      for (int k = 0; k < 3; ++k) lit.ptr(y)[3 * x + k] = static_cast<std::uint8_t>((20 + 225 * light) * pale[k] / 215);
    }
  EXPECT_EQ(masked(weights_of(lit)), 0);
}

TEST(GlareWeights, ColouredLightIsNotAHighlight) {
  cv::Mat bgr(vga, CV_8UC3, tissue);
  bgr({300, 200, 9, 7}).setTo(cv::Scalar(60, 90, 255));
  EXPECT_EQ(masked(weights_of(bgr)), 0);
}

TEST(GlareWeights, InGrayOnlyLumaCounts) {
  cv::Mat bgr(vga, CV_8UC3, tissue);
  bgr({300, 200, 9, 7}).setTo(cv::Scalar(60, 180, 255));  // Y 189 on 90
  EXPECT_EQ(masked(weights_of(bgr)), 0);
  EXPECT_GT(masked(weights_of(bgr, {}, test::Layout::gray8)), 9 * 7);
}

TEST(GlareWeights, AClippedPixelShowsNothing) {
  cv::Mat bgr(vga, CV_8UC3, tissue);
  bgr({300, 200, 9, 7}).setTo(cv::Scalar(250, 251, 255));
  bgr({301, 200, 1, 7}).setTo(cv::Scalar(249, 255, 255));
  const auto weights = weights_of(bgr);
  EXPECT_EQ(weights.level(0).at<std::uint8_t>(203, 300), GlareWeights::nothing);
  EXPECT_EQ(weights.level(0).at<std::uint8_t>(203, 301), GlareWeights::highlight) << "one channel is not clipped";
  EXPECT_EQ(weights.level(0).at<std::uint8_t>(203, 299), GlareWeights::highlight) << "its rim";
}

TEST(GlareWeights, AHighlightOnForbiddenGroundIsForbidden) {
  cv::Mat bgr(vga, CV_8UC3, tissue), forbidden = cv::Mat::zeros(vga, CV_8UC1);
  bgr({300, 200, 9, 7}).setTo(white);
  forbidden({300, 200, 4, 7}).setTo(255);
  const auto weights = weights_of(bgr, forbidden);
  EXPECT_EQ(weights.level(0).at<std::uint8_t>(203, 303), GlareWeights::nothing);
  EXPECT_EQ(weights.level(0).at<std::uint8_t>(203, 304), GlareWeights::highlight);
}

TEST(GlareWeights, AValueSaysWhatAPixelShowsAndHowMuchOfIt) {
  constexpr float highlight = GlareWeights::highlight / 255.F;
  const auto expect = [](float value, float tissue, float shown) {
    EXPECT_FLOAT_EQ(GlareWeights::tissue_share(value), tissue) << value;
    EXPECT_FLOAT_EQ(GlareWeights::shown_share(value), shown) << value;
  };
  expect(1, 1, 1);
  expect((1 + highlight) / 2, .5F, 1);
  expect(highlight / 2, 0, .5F);
  expect(0, 0, 0);
  EXPECT_EQ(GlareWeights::tissue_share(highlight), 0) << "exactly: its contrast is large";
  EXPECT_EQ(GlareWeights::shown_share(highlight), 1);
}

TEST(GlareWeights, ForbiddenPixelsWeighNothingAndDoNotDarkenTheBackground) {
  // A dark border takes three quarters of the cells at the corner of pale tissue.
  cv::Mat bgr(vga, CV_8UC3, cv::Scalar(0, 0, 0)), forbidden(vga, CV_8UC1, cv::Scalar(255));
  const cv::Rect field(160, 120, 320, 240);
  bgr(field).setTo(pale);
  forbidden(field).setTo(0);
  const auto weights = weights_of(bgr, forbidden);
  EXPECT_EQ(cv::norm(weights.level(0), 255 - forbidden, cv::NORM_INF), 0);
}

/// How far each pixel exceeds the highlight limit, as the header defines it, in double.
cv::Mat1d excess(const cv::Mat &least) {
  const int cell = static_cast<int>(std::lround(16 * least.rows / 480.));
  const int columns = (least.cols + cell - 1) / cell, rows = (least.rows + cell - 1) / cell;
  cv::Mat1d mean(rows, columns), median(rows, columns), out(least.size());
  for (int j = 0; j < rows; ++j)
    for (int i = 0; i < columns; ++i) {
      const cv::Rect r = cv::Rect(i * cell, j * cell, cell, cell) & cv::Rect({0, 0}, least.size());
      mean(j, i) = std::floor(cv::mean(least(r))[0] + .5);
    }
  for (int j = 0; j < rows; ++j)
    for (int i = 0; i < columns; ++i) {
      std::vector<double> around;
      for (int b = -2; b <= 2; ++b)
        for (int a = -2; a <= 2; ++a)
          around.push_back(mean(std::clamp(j + b, 0, rows - 1), std::clamp(i + a, 0, columns - 1)));
      std::sort(around.begin(), around.end());
      median(j, i) = around[12];
    }
  const auto at = [&](int i, int j) { return median(std::clamp(j, 0, rows - 1), std::clamp(i, 0, columns - 1)); };
  const auto mirror = [](int i, int n) { return i < 0 ? -i : i >= n ? 2 * n - 2 - i : i; };
  for (int y = 0; y < least.rows; ++y)
    for (int x = 0; x < least.cols; ++x) {
      double m = 0;
      for (int j = -1; j <= 1; ++j)
        for (int i = -1; i <= 1; ++i)
          m += (2 - std::abs(i)) * (2 - std::abs(j)) / 16. *
               least.ptr(mirror(y + j, least.rows))[mirror(x + i, least.cols)];
      const double u = (x + .5) / cell - .5, v = (y + .5) / cell - .5;
      const int i = static_cast<int>(std::floor(u)), j = static_cast<int>(std::floor(v));
      const double background = (1 - v + j) * ((1 - u + i) * at(i, j) + (u - i) * at(i + 1, j)) +
                                (v - j) * ((1 - u + i) * at(i, j + 1) + (u - i) * at(i + 1, j + 1));
      out(y, x) = m - background - .4 * (250 - background);
    }
  return out;
}

/// The mask of pixels that exceed the limit by more than `margin`.
cv::Mat reference_mask(const cv::Mat1d &excess, double margin) {
  cv::Mat mask = excess > margin;
  cv::dilate(mask, mask, cv::Mat::ones(5, 5, CV_8U));
  return mask;
}

cv::Mat darkest(const WorkFrame &frame) {
  cv::Mat bgr, planes[3];
  frame.gather_bgr({{0, 0}, frame.size()}, bgr);
  cv::split(bgr, planes);
  return cv::min(cv::min(planes[0], planes[1]), planes[2]);
}

TEST(GlareWeights, IsAsDefined) {
  for (const cv::Size size :
       {cv::Size(640, 480), cv::Size(357, 288), cv::Size(161, 117), cv::Size(53, 576), cv::Size(40, 90)})
    for (const auto layout : {test::Layout::bgr, test::Layout::i420, test::Layout::y444_10le, test::Layout::gray8}) {
      SCOPED_TRACE(testing::Message() << size.width << " x " << size.height << " " << static_cast<int>(layout));
      cv::Mat bgr = test::Texture(4).render(size);
      bgr({size.width / 3, size.height / 3, 3, 4}).setTo(white);
      const auto packed = test::pack(bgr, layout);
      WorkFrame frame;
      frame.load(packed.view);
      GlareWeights weights;
      weights.build(frame, {});
      const cv::Mat masked = weights.level(0) != GlareWeights::tissue;
      const cv::Mat1d above = excess(darkest(frame));
      const auto count = [&](int value) { return cv::countNonZero(weights.level(0) == value); };
      EXPECT_EQ(count(GlareWeights::tissue) + count(GlareWeights::highlight) + count(GlareWeights::nothing),
                size.area());
      EXPECT_EQ(cv::countNonZero(masked & ~reference_mask(above, -.02)), 0);
      EXPECT_EQ(cv::countNonZero(~masked & reference_mask(above, .02)), 0);
      EXPECT_GT(cv::countNonZero(masked), 0);
      EXPECT_LT(cv::countNonZero(masked), size.area() * 9 / 10);
    }
}

/// In a picture larger than the working image, chroma comes from the nearest sample. The mask is then as defined up to
/// one pixel, except in a few places.
TEST(GlareWeights, OnALargeClipIsAsDefinedWithinAPixel) {
  auto video = test::open_clip("cholecystectomy.mp4");
  if (!video.isOpened()) GTEST_SKIP() << "no clips: set CSDTRACK_CLIPS";
  cv::Mat bgr;
  for (int i = 0; video.read(bgr); ++i) {
    if (i % 50 != 0) continue;
    for (const auto layout : {test::Layout::i420, test::Layout::rgb}) {
      const auto packed = test::pack(bgr, layout);
      WorkFrame frame;
      frame.load(packed.view);
      GlareWeights weights;
      weights.build(frame, {});
      const cv::Mat least = darkest(frame), masked = weights.level(0) != GlareWeights::tissue;
      const cv::Mat expected = reference_mask(excess(least), 0) | (least >= 250);
      cv::Mat wide_masked, wide_expected;
      cv::dilate(masked, wide_masked, {});
      cv::dilate(expected, wide_expected, {});
      const int wrong = cv::countNonZero(masked & ~wide_expected) + cv::countNonZero(expected & ~wide_masked);
      EXPECT_LT(wrong, cv::countNonZero(expected) / 100) << i;
    }
  }
}

TEST(GlareWeights, RefusesMasksOfOtherSizes) {
  const cv::Mat bgr(vga, CV_8UC3, tissue);
  EXPECT_THROW(weights_of(bgr, cv::Mat::zeros(480, 639, CV_8UC1)), std::invalid_argument);
  EXPECT_THROW(weights_of(bgr, cv::Mat::zeros(480, 640, CV_16UC1)), std::invalid_argument);
  EXPECT_EQ(cv::countNonZero(weights_of(bgr, cv::Mat(vga, CV_8UC1, cv::Scalar(255))).level(0)), 0);
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
