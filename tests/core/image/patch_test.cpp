// SPDX-License-Identifier: LGPL-2.1-or-later
#include "image/patch.h"

#include <gtest/gtest.h>
#include <opencv2/imgproc.hpp>

#include <cmath>
#include <limits>

#include "core/picture.h"
#include "image/warps.h"

namespace csd {
namespace {

cv::Mat same_type(const cv::Mat &bgr, int channels) {
  cv::Mat out;
  if (channels == 3) return bgr;
  cv::extractChannel(bgr, out, 1);
  return out;
}

TEST(Patch, CopiesWholePixelsAndRepeatsTheBorder) {
  const cv::Mat bgr = test::Texture(1).render({30, 20});
  for (const int channels : {1, 3}) {
    const cv::Mat source = same_type(bgr, channels);
    cv::Mat patch, extended;
    sample_patch(source, {12, 9}, 11, patch);
    EXPECT_EQ(cv::norm(patch, source({7, 4, 11, 11}), cv::NORM_INF), 0);
    cv::copyMakeBorder(source, extended, 10, 10, 10, 10, cv::BORDER_REPLICATE);
    sample_patch(source, {28, 1}, 11, patch);
    EXPECT_EQ(cv::norm(patch, extended({33, 6, 11, 11}), cv::NORM_INF), 0);
  }
}

TEST(Patch, IsBilinearAsComputedByHand) {
  const cv::Mat source = (cv::Mat_<std::uint8_t>(2, 2) << 0, 100, 40, 200);
  cv::Mat patch;
  sample_patch(source, {0.5, 0.25}, 1, patch);
  EXPECT_EQ(patch.at<std::uint8_t>(0, 0), 68);  // .75·50 + .25·120 = 67.5
}

TEST(Patch, AWarpShowsTheTextureItMapsTo) {
  const test::Texture texture(4);
  const cv::Mat source = same_type(texture.render({100, 100}), 1);
  const cv::Point2d centre(50.3, 48.7);
  for (const Warp &h : geometric_warps(21)) {
    cv::Mat patch;
    sample_patch(source, centre, 21, h, patch);
    for (int v = -10; v <= 10; ++v)
      for (int u = -10; u <= 10; ++u) {
        const cv::Vec3d p = h * cv::Vec3d(u, v, 1);
        const double exact = texture.at(centre.x + p[0] / p[2], centre.y + p[1] / p[2], 1);
        ASSERT_NEAR(patch.at<std::uint8_t>(v + 10, u + 10), exact, 6);
      }
  }
}

TEST(Patch, FarAndDegenerateWarpsAreSafe) {
  const cv::Mat source(5, 5, CV_8UC1, cv::Scalar(9));
  cv::Mat patch;
  sample_patch(source, {1e300, -1e300}, 5, patch);
  EXPECT_EQ(cv::countNonZero(patch != 9), 0);
  sample_patch(source, {2, 2}, 5, Warp::zeros(), patch);
  EXPECT_EQ(cv::countNonZero(patch != 9), 0);
  EXPECT_THROW(sample_patch(source, {2, 2}, 4, patch), std::invalid_argument);
  EXPECT_THROW(sample_patch(source, {std::nan(""), 2}, 5, patch), std::invalid_argument);
  EXPECT_THROW(sample_patch(cv::Mat(), {2, 2}, 5, patch), std::invalid_argument);
}

}  // namespace
}  // namespace csd
