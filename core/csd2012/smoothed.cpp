// SPDX-License-Identifier: LGPL-2.1-or-later
#include "csd2012/smoothed.h"

#include <cmath>
#include <opencv2/imgproc.hpp>

namespace csd::csd2012 {

int smoothing_margin(double sigma) {
  return static_cast<int>(std::ceil(2.5 * sigma));
}

void smooth(const cv::Mat &grown, double sigma, cv::Mat &out) {
  const int margin = smoothing_margin(sigma);
  if (margin == 0) {
    out = grown;
    return;
  }
  cv::Mat smoothed;
  cv::GaussianBlur(grown, smoothed, {2 * margin + 1, 2 * margin + 1}, sigma, sigma, cv::BORDER_REPLICATE);
  out = smoothed({margin, margin, grown.cols - 2 * margin, grown.rows - 2 * margin});
}

std::vector<cv::Mat> smooth_each(const cv::Mat &stack, double sigma) {
  const int side = stack.cols, inside = side - 2 * smoothing_margin(sigma), count = stack.rows / side;
  // Side by side, as OpenCV is slow at the ends of rows. Only margins mix across patches.
  cv::Mat row(side, count * side, stack.type()), smoothed;
  for (int i = 0; i < count; ++i) {
    const cv::Range patch(i * side, (i + 1) * side);
    stack.rowRange(patch).copyTo(row.colRange(patch));
  }
  smooth(row, sigma, smoothed);
  std::vector<cv::Mat> out;
  out.reserve(static_cast<std::size_t>(count));
  for (int i = 0; i < count; ++i) out.push_back(smoothed({i * side, 0, inside, inside}));
  return out;
}

}  // namespace csd::csd2012
