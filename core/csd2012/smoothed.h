// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <opencv2/core.hpp>

namespace csd::csd2012 {

/// Radius in pixels at which a Gaussian of `sigma` pixels is truncated.
int smoothing_margin(double sigma);
/// `grown`: CV_8UC1, the picture with a margin of smoothing_margin() on each side. `out` becomes the picture without
/// it, smoothed; with sigma 0, a view of `grown`.
void smooth(const cv::Mat &grown, double sigma, cv::Mat &out);

}  // namespace csd::csd2012
