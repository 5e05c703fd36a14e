// SPDX-License-Identifier: LGPL-2.1-or-later
#include "content/specular.h"

#include <gtest/gtest.h>

#include "core/picture.h"
#include "image/work_frame.h"

namespace csd {
namespace {

cv::Mat mask_of(const cv::Mat &bgr, const cv::Rect &r, const SpecularOptions &options = {},
                test::Layout layout = test::Layout::bgr) {
  const auto packed = test::pack(bgr, layout);
  WorkFrame frame;
  frame.load(packed.view);
  cv::Mat mask;
  specular_mask(frame, r, mask, options);
  return mask;
}

TEST(Specular, ThresholdsValueAndSaturation) {
  cv::Mat bgr(1, 6, CV_8UC3, cv::Scalar(0, 0, 0));
  const cv::Vec3b pixels[] = {{255, 255, 255}, {220, 220, 220}, {219, 219, 219},  // V ≥ 219.3
                              {180, 200, 240}, {179, 200, 240}, {255, 0, 0}};     // S = 60/240 = 0.25; 61/240
  for (int x = 0; x < 6; ++x) bgr.at<cv::Vec3b>(0, x) = pixels[x];
  const cv::Mat mask = mask_of(bgr, {0, 0, 6, 1});
  const cv::Mat expected = (cv::Mat_<std::uint8_t>(1, 6) << 255, 255, 0, 255, 0, 0);
  EXPECT_EQ(cv::norm(mask, expected, cv::NORM_INF), 0);
}

TEST(Specular, TheMarginReachesIntoTheRectangleFromOutside) {
  EXPECT_EQ(specular_margin(576), 5);
  EXPECT_EQ(specular_margin(288), 3);
  cv::Mat bgr(576, 60, CV_8UC3, cv::Scalar(40, 40, 90));
  bgr.at<cv::Vec3b>(300, 20) = {250, 250, 250};
  const cv::Mat whole = mask_of(bgr, {0, 0, 60, 576});
  EXPECT_EQ(whole.at<std::uint8_t>(300, 25), 255);
  EXPECT_EQ(whole.at<std::uint8_t>(300, 26), 0);
  EXPECT_EQ(whole.at<std::uint8_t>(305, 20), 255);
  EXPECT_EQ(whole.at<std::uint8_t>(305, 25), 0);  // round, not square
  const cv::Rect r(22, 298, 20, 20);
  EXPECT_EQ(cv::norm(mask_of(bgr, r), whole(r), cv::NORM_INF), 0);
  const cv::Mat beyond = mask_of(bgr, {-10, -10, 80, 600});
  EXPECT_EQ(cv::norm(beyond({10, 10, 60, 576}), whole, cv::NORM_INF), 0);
  EXPECT_EQ(cv::countNonZero(beyond), cv::countNonZero(whole));
}

TEST(Specular, InGrayOnlyLumaCounts) {
  cv::Mat bgr(8, 8, CV_8UC3, cv::Scalar(255, 255, 255));
  EXPECT_EQ(cv::countNonZero(mask_of(bgr, {0, 0, 8, 8}, {}, test::Layout::gray8)), 64);
  EXPECT_EQ(cv::countNonZero(mask_of(bgr * 0.5, {0, 0, 8, 8}, {}, test::Layout::gray8)), 0);
}

}  // namespace
}  // namespace csd
