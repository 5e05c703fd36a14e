// SPDX-License-Identifier: LGPL-2.1-or-later
#include "image/glare_weights.h"

#include <opencv2/imgproc.hpp>

#include <algorithm>
#include <cmath>

#include "image/work_frame.h"

namespace csd {
namespace {

cv::Mat least_of_bgr(const WorkFrame &frame) {
  cv::Mat bgr, least(frame.size(), CV_8UC1);
  frame.gather_bgr({{0, 0}, frame.size()}, bgr);
  for (int y = 0; y < bgr.rows; ++y)
    for (int x = 0; x < bgr.cols; ++x) {
      const std::uint8_t *p = bgr.ptr(y) + 3 * x;
      least.ptr(y)[x] = std::min({p[0], p[1], p[2]});
    }
  return least;
}

/// Mean of each cell × cell pixels, of those that are allowed; what has too few of them takes the nearest one's.
cv::Mat means_of_cells(const cv::Mat &least, const cv::Mat &forbidden, int cell) {
  const int columns = (least.cols + cell - 1) / cell, rows = (least.rows + cell - 1) / cell;
  cv::Mat1b mean(rows, columns), known(rows, columns);
  for (int j = 0; j < rows; ++j)
    for (int i = 0; i < columns; ++i) {
      int sum = 0, count = 0;
      for (int y = j * cell; y < std::min((j + 1) * cell, least.rows); ++y)
        for (int x = i * cell; x < std::min((i + 1) * cell, least.cols); ++x)
          if (forbidden.empty() || !forbidden.ptr(y)[x]) {
            sum += least.ptr(y)[x];
            ++count;
          }
      known(j, i) = count > 0;
      mean(j, i) = count ? static_cast<std::uint8_t>((sum + count / 2) / count) : 0;
    }
  for (int j = 0; j < rows; ++j)
    for (int i = 0; i < columns; ++i)
      if (!known(j, i)) {
        int best = rows * rows + columns * columns;
        for (int b = 0; b < rows; ++b)
          for (int a = 0; a < columns; ++a)
            if (const int d = (a - i) * (a - i) + (b - j) * (b - j); known(b, a) && d < best) {
              best = d;
              mean(j, i) = mean(b, a);
            }
      }
  return mean;
}

}  // namespace

void GlareWeights::build(const WorkFrame &frame, const cv::Mat &forbidden) {
  const cv::Size size = frame.size();
  const auto scaled = [&](int pixels) { return static_cast<int>(std::lround(pixels * size.height / 480.)); };
  const int cell = std::max(1, scaled(16)), reach = scaled(2);

  const cv::Mat least = least_of_bgr(frame);
  cv::Mat smooth, background, marked;
  const cv::Mat tent = (cv::Mat_<float>(3, 1) << .25f, .5f, .25f);
  cv::sepFilter2D(least, smooth, CV_32F, tent, tent);
  cv::medianBlur(means_of_cells(least, forbidden, cell), background, 5);
  cv::resize(background, background, {background.cols * cell, background.rows * cell}, 0, 0, cv::INTER_LINEAR);
  background({{0, 0}, size}).convertTo(background, CV_32F);
  marked = smooth - background > .2 * (250 - background);
  cv::dilate(marked, marked, cv::Mat::ones(2 * reach + 1, 2 * reach + 1, CV_8U));
  if (!forbidden.empty()) marked |= forbidden;
  levels_[0] = ~marked;
  for (std::size_t l = 1; l < Pyramid::levels; ++l) {
    const cv::Mat &fine = levels_[l - 1];
    cv::Mat mean;
    cv::sepFilter2D(fine, mean, CV_32F, tent, tent);
    levels_[l].create((fine.rows + 1) / 2, (fine.cols + 1) / 2, CV_8UC1);
    for (int y = 0; y < levels_[l].rows; ++y)
      for (int x = 0; x < levels_[l].cols; ++x)
        levels_[l].ptr(y)[x] = cv::saturate_cast<std::uint8_t>(mean.at<float>(2 * y, 2 * x) + .01f);
  }
}

}  // namespace csd
