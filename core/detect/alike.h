// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <opencv2/core.hpp>

namespace csd {

/// Measures how similar a place is to the tissue around it. Along an edge and in repeated texture a patch fits as well
/// elsewhere: only the motion around it then locates the point.
class LookAlikes {
 public:
  /// `luma`: CV_8UC1, the working image; `patch`: odd side of the patch, working pixels.
  LookAlikes(const cv::Mat &luma, int patch);

  /// The highest zero-mean normalised cross-correlation of the patch at `at` with patches a third to two thirds of its
  /// side away, −1…1, at half the resolution. 1 if the picture's edge leaves no room or there is no texture.
  double best(cv::Point2d at) const;

 private:
  cv::Mat half_;
  int radius_, reach_, near_;  // of the half picture
};

}  // namespace csd
