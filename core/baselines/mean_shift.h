// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <opencv2/core.hpp>

#include <optional>

#include "baselines/colour_weights.h"

namespace csd {

/// The weights in a square window.
struct WindowMass {
  std::uint64_t mass = 0;  ///< their sum
  cv::Point2d centroid;    ///< of them, in pixels of the image; the window's centre where the mass is 0
};

/// Of the window of odd `side` about the pixel nearest to `centre`; what of it lies outside `values` (CV_8UC1) has no
/// weight.
WindowMass window_mass(const cv::Mat &values, const ColourWeights &weights, cv::Point2d centre, int side);

/// Mean shift with a flat kernel of fixed size: the window is moved to its centroid until that moves by less than half
/// a pixel, 20 times at most. Nothing where there is no weight in a window on the way.
std::optional<cv::Point2d> mean_shift(const cv::Mat &values, const ColourWeights &weights, cv::Point2d start, int side);

}  // namespace csd
