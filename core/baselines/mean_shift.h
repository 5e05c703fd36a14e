// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <opencv2/core.hpp>

#include <optional>

#include "baselines/colour_weights.h"

namespace csd {

/// The weights in a square window.
struct WindowMass {
  std::uint64_t mass = 0;  ///< sum of the weights
  cv::Point2d centroid;    ///< weighted, in pixels of the image; the window's centre if the mass is 0
};

/// Of the window of odd `side` around the pixel nearest to `centre`; pixels outside `values` (CV_8UC1) have no weight.
WindowMass window_mass(const cv::Mat &values, const ColourWeights &weights, cv::Point2d centre, int side);

/// Mean shift with a flat kernel of fixed size: moves the window to its centroid until that moves by less than half a
/// pixel, at most 20 times. Empty if a window on the way has no weight.
std::optional<cv::Point2d> mean_shift(const cv::Mat &values, const ColourWeights &weights, cv::Point2d start, int side);

}  // namespace csd
