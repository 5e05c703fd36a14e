// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <opencv2/core.hpp>

#include <optional>
#include <vector>

#include "learn/tree.h"

namespace csd {

/// Positions that a descriptor calls "feature", and the best of them (§2.1.4).
struct SearchResult {
  std::optional<cv::Point> best;   ///< none: nothing is labelled feature, the feature is hidden (A29)
  double weighted = 0;             ///< its probability times the weight of its place
  std::vector<cv::Point> matches;  ///< all positions labelled feature, row by row
};

/// §2.1.4: among `centres`, the patch labelled feature with the largest P(N) = |a|·|b|⁻¹ times a Gaussian
/// around the last known position; equals go to the nearest, then to the first.
///
/// `channel`: CV_8UC1 in the descriptor's colour space, whose pixel (0,0) is `origin` in working coordinates; `centres`:
/// working coordinates, the patches around them lie in the channel. `sigma`: working pixels; infinite: no weighting.
SearchResult search(const Tree &descriptor, const cv::Mat &channel, cv::Point origin, const cv::Rect &centres,
                    cv::Point2d last, double sigma);

}  // namespace csd
