// SPDX-License-Identifier: LGPL-2.1-or-later
#include "sim/clock.h"

#include <gtest/gtest.h>

#include <string>

namespace csd::sim {
namespace {

cv::Mat with_clock(double time, cv::Size size = {640, 480}) {
  cv::Mat picture(size, CV_8UC3, cv::Scalar(50, 60, 70));
  draw_clock(time, picture);
  return picture;
}

/// The dots of the n-th letter (5 × 7, each 2 pixels at 480 lines), row by row.
std::string letter(const cv::Mat &picture, int n) {
  const cv::Rect box = clock_box(picture.size());
  std::string dots;
  for (int y = 0; y < 7; ++y)
    for (int x = 0; x < 5; ++x)
      dots += picture.at<cv::Vec3b>(box.y + 2 * (2 + y), box.x + 2 * (2 + 6 * n + x))[0] > 128 ? '#' : '.';
  return dots;
}

TEST(Clock, ShowsTheTime) {
  // "REC 0:01:02.3"
  const cv::Mat picture = with_clock(62.34);
  const std::string zero = ".###.#...##..###.#.###..##...#.###.", one = "..#...##....#....#....#....#...###.";
  EXPECT_EQ(letter(picture, 4), zero);
  EXPECT_EQ(letter(picture, 6), zero);
  EXPECT_EQ(letter(picture, 7), one);
  EXPECT_EQ(letter(picture, 9), zero);
  EXPECT_NE(letter(picture, 10), letter(picture, 12));
  EXPECT_EQ(letter(with_clock(3600 + 62.34), 4), one);
}

TEST(Clock, StaysInItsBox) {
  const cv::Mat picture = with_clock(1);
  const cv::Rect box = clock_box(picture.size());
  EXPECT_EQ(box & cv::Rect({}, picture.size()), box);
  for (int y = 0; y < picture.rows; ++y)
    for (int x = 0; x < picture.cols; ++x)
      if (!box.contains({x, y})) {
        ASSERT_EQ(picture.at<cv::Vec3b>(y, x), cv::Vec3b(50, 60, 70));
      }
  EXPECT_NO_THROW(with_clock(1, {16, 16}));
}

}  // namespace
}  // namespace csd::sim
