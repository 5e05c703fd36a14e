// SPDX-License-Identifier: LGPL-2.1-or-later
#include "detect/alike.h"

#include <opencv2/imgproc.hpp>

#include <algorithm>
#include <cmath>

namespace csd {

LookAlikes::LookAlikes(const cv::Mat &luma, int patch)
    : radius_(std::max(2, patch / 4)), reach_(std::max(2, patch / 3)), near_(std::max(1, patch / 6)) {
  cv::pyrDown(luma, half_);
}

double LookAlikes::best(cv::Point2d at) const {
  const cv::Point centre(cvRound(at.x / 2), cvRound(at.y / 2));
  const auto about = [&](int r) { return cv::Rect(centre.x - r, centre.y - r, 2 * r + 1, 2 * r + 1); };
  const cv::Rect picture({0, 0}, half_.size()), patch = about(radius_), around = about(radius_ + reach_) & picture;
  if ((patch & picture) != patch) return 1;
  cv::Mat fit;
  cv::matchTemplate(half_(around), half_(patch), fit, cv::TM_CCOEFF_NORMED);
  double best = -1;
  for (int y = 0; y < fit.rows; ++y)
    for (int x = 0; x < fit.cols; ++x) {
      const int dx = x + around.x - patch.x, dy = y + around.y - patch.y, d = dx * dx + dy * dy;
      if (d >= near_ * near_ && d <= reach_ * reach_) best = std::max(best, double{fit.at<float>(y, x)});
    }
  return best;
}

}  // namespace csd
