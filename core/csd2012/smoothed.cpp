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

}  // namespace csd::csd2012
