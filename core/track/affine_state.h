// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <opencv2/core.hpp>

namespace csd {

/// Where a feature is and what its surroundings' shape has become: an offset u from the feature in the frame where it
/// began (working pixels) is seen at position + shape·u.
struct AffineState {
  cv::Point2d position;                    ///< working pixels
  cv::Matx22d shape = cv::Matx22d::eye();  ///< determinant > 0
  double scale() const;                    ///< √det shape
};

}  // namespace csd
