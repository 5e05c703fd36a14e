// SPDX-License-Identifier: LGPL-2.1-or-later
#include "detect/alike.h"

#include <gtest/gtest.h>
#include <opencv2/imgproc.hpp>

#include <cmath>

namespace {

constexpr int patch = 21;

TEST(LookAlikes, AnEdgeResemblesItselfAndACornerDoesNot) {
  cv::Mat luma(120, 160, CV_8UC1, cv::Scalar(60));
  luma(cv::Rect(80, 40, 80, 80)).setTo(160);
  const csd::LookAlikes alike(luma, patch);
  EXPECT_NEAR(alike.best({80, 85}), 1, 1e-3);
  EXPECT_LT(alike.best({80, 40}), 0.8);
}

TEST(LookAlikes, SeesRepeatedTexture) {
  cv::Mat luma(120, 160, CV_8UC1, cv::Scalar(60)), single = luma.clone();
  const int period = 12;  // within two thirds of a patch's side
  for (int y = 6; y < luma.rows; y += period)
    for (int x = 8; x < luma.cols; x += period) cv::circle(luma, {x, y}, 2, cv::Scalar(160), cv::FILLED);
  cv::circle(single, {80, 66}, 2, cv::Scalar(160), cv::FILLED);
  EXPECT_GT(csd::LookAlikes(luma, patch).best({80, 66}), 0.95);
  EXPECT_LT(csd::LookAlikes(single, patch).best({80, 66}), 0.5);
}

TEST(LookAlikes, WithoutRoomOrTextureEverythingIsAlike) {
  const cv::Mat flat(120, 160, CV_8UC1, cv::Scalar(90));
  cv::Mat noisy(120, 160, CV_8UC1);
  cv::randu(noisy, 0, 255);
  EXPECT_EQ(csd::LookAlikes(noisy, patch).best({2, 60}), 1);
  EXPECT_EQ(csd::LookAlikes(noisy, patch).best({159, 119}), 1);
  EXPECT_GE(csd::LookAlikes(flat, patch).best({80, 60}), 0.99);
  EXPECT_LT(csd::LookAlikes(noisy, patch).best({80, 60}), 0.9);
}

}  // namespace
