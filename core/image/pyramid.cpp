// SPDX-License-Identifier: LGPL-2.1-or-later
#include "image/pyramid.h"

#include <opencv2/imgproc.hpp>

#include <stdexcept>

namespace csd {

void Pyramid::build(const cv::Mat &luma) {
  constexpr int smallest = 16;
  if (luma.type() != CV_8UC1 || luma.cols < smallest || luma.rows < smallest)
    throw std::invalid_argument("Pyramid: wants CV_8UC1 of at least 16 x 16 pixels");
  cv::Mat exact;
  const cv::Mat kernel = (cv::Mat_<float>(5, 1) << 1, 4, 6, 4, 1);
  cv::sepFilter2D(luma, exact, CV_32F, kernel, kernel, {-1, -1}, 0, cv::BORDER_REFLECT_101 | cv::BORDER_ISOLATED);
  exact.convertTo(levels_[0], CV_16U);
  for (std::size_t l = 1; l < levels; ++l) cv::pyrDown(levels_[l - 1], levels_[l]);
}

}  // namespace csd
