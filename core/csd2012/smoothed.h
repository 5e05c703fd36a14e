// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <opencv2/core.hpp>

#include <vector>

namespace csd::csd2012 {

/// Radius in pixels at which a Gaussian of `sigma` pixels is truncated.
int smoothing_margin(double sigma);
/// `grown`: 8 bit, the picture with a margin of smoothing_margin() on each side. `out` becomes the picture without
/// it, smoothed; with sigma 0, a view of `grown`.
void smooth(const cv::Mat &grown, double sigma, cv::Mat &out);
/// The same for each patch of `stack`: 8 bit, square patches as wide as the stack, one below the other, each with its
/// own margin. The results are views of one picture.
std::vector<cv::Mat> smooth_each(const cv::Mat &stack, double sigma);

}  // namespace csd::csd2012
