// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <opencv2/core.hpp>

namespace csd::csd2012 {

/// Pixels around what is to be smoothed that a Gaussian of `sigma` pixels reaches: its sums are cut off there.
int smoothing_margin(double sigma);
/// `grown`: CV_8UC1, the picture with smoothing_margin() more on each side; `out` becomes what lies inside, smoothed.
/// With sigma 0 it is a view of `grown`.
void smooth(const cv::Mat &grown, double sigma, cv::Mat &out);

}  // namespace csd::csd2012
