// SPDX-License-Identifier: LGPL-2.1-or-later
#include "image/area_scaler.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "core/simd_targets.h"

namespace csd {
namespace {

cv::Mat noise(cv::Size size) {
  cv::Mat out(size, CV_8UC1);
  cv::RNG(7).fill(out, cv::RNG::UNIFORM, 0, 256);
  return out;
}

RowReader reader(const cv::Mat &m) {
  return [&m](int row, int first, int n, std::uint8_t *buffer) {
    std::copy_n(m.ptr(row) + first, n, buffer);
    return static_cast<const std::uint8_t *>(buffer);
  };
}

/// The mean of the picture, constant over each pixel, over output (i, j), straight from its definition.
double exact(const cv::Mat &m, cv::Size picture, int sub, cv::Size out, int i, int j) {
  const double sx = static_cast<double>(picture.width) / out.width,
               sy = static_cast<double>(picture.height) / out.height;
  double sum = 0;
  for (int y = 0; y < picture.height; ++y) {
    const double h = std::min(y + 1.0, (j + 1) * sy) - std::max<double>(y, j * sy);
    if (h <= 0) continue;
    for (int x = 0; x < picture.width; ++x) {
      const double w = std::min(x + 1.0, (i + 1) * sx) - std::max<double>(x, i * sx);
      if (w > 0) sum += w * h * m.at<std::uint8_t>(y >> sub, x >> sub);
    }
  }
  return sum / (sx * sy);
}

TEST(ScaleArea, IsTheMeanOfTheCoveredPixels) {
  struct Case {
    cv::Size picture, out;
  };
  for (const Case &c : {Case{{50, 40}, {40, 32}}, Case{{75, 60}, {40, 32}}, Case{{61, 47}, {19, 13}},
                        Case{{33, 17}, {33, 9}}, Case{{9, 90}, {1, 10}}, Case{{1300, 9}, {1040, 7}}})
    for (const int sub : {0, 1}) {
      const cv::Size samples((c.picture.width + sub) >> sub, (c.picture.height + sub) >> sub);
      const cv::Mat in = noise(samples);
      cv::Mat out(c.out, CV_8UC1);
      scale_area(AreaAxis(c.picture.width, sub, c.out.width), AreaAxis(c.picture.height, sub, c.out.height), reader(in),
                 {0, c.out.height}, out);
      for (int j = 0; j < out.rows; ++j)
        for (int i = 0; i < out.cols; ++i)
          ASSERT_NEAR(out.at<std::uint8_t>(j, i), exact(in, c.picture, sub, c.out, i, j), 0.75) << c.picture << i << j;
    }
}

TEST(ScaleArea, KeepsAConstantPicture) {
  for (const int value : {0, 1, 128, 254, 255}) {
    const cv::Mat in(400, 400, CV_8UC1, cv::Scalar(value));
    cv::Mat out(7, 11, CV_8UC1);
    scale_area(AreaAxis(400, 0, 11), AreaAxis(400, 0, 7), reader(in), {0, 7}, out);
    EXPECT_EQ(cv::countNonZero(out != value), 0) << value;
  }
}

TEST(ScaleArea, RowsDoNotDependOnTheRange) {
  const cv::Mat in = noise({130, 97});
  const AreaAxis columns(130, 0, 71), rows(97, 0, 53);
  cv::Mat at_once(53, 71, CV_8UC1), in_parts(53, 71, CV_8UC1);
  scale_area(columns, rows, reader(in), {0, 53}, at_once);
  for (const cv::Range r : {cv::Range(0, 5), cv::Range(5, 6), cv::Range(6, 40), cv::Range(40, 53)})
    scale_area(columns, rows, reader(in), r, in_parts);
  EXPECT_EQ(cv::norm(at_once, in_parts, cv::NORM_INF), 0);
}

void kernels_are_their_scalar_twins() {
  const cv::Mat in = noise({203, 8});
  const AreaAxis axis(203, 0, 77);
  for (int n = 1; n < 200; ++n)
    for (const int at : {0, 1, 3}) {
      const std::uint8_t *rows[] = {in.ptr(0) + at, in.ptr(1), in.ptr(2) + 1};
      const std::uint16_t weights[] = {20000, 40000, 5535};
      std::vector<std::uint16_t> fast(static_cast<std::size_t>(n)), slow(fast);
      blend_rows(rows, weights, 3, n, fast.data());
      scalar::blend_rows(rows, weights, 3, n, slow.data());
      ASSERT_EQ(fast, slow) << n;
    }
  cv::Mat wide(8, 208, CV_16UC1);
  cv::RNG(3).fill(wide, cv::RNG::UNIFORM, 0, 65281);
  std::vector<std::uint16_t> scratch(8 * 208);
  cv::Mat fast(8, 80, CV_8UC1), slow(8, 80, CV_8UC1);
  blend_columns(axis, 0, 80, wide.ptr<std::uint16_t>(), 208, 208, scratch.data(), fast.data, 80);
  scalar::blend_columns(axis, 0, 80, wide.ptr<std::uint16_t>(), 208, 208, scratch.data(), slow.data, 80);
  EXPECT_EQ(cv::norm(fast, slow, cv::NORM_INF), 0);
}

TEST(ScaleArea, KernelsMatchTheirScalarTwins) {
  test::on_all_targets(kernels_are_their_scalar_twins);
}

}  // namespace
}  // namespace csd
