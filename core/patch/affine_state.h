// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <opencv2/core.hpp>

namespace csd {

/// Where a feature is and what its surroundings' shape has become: sample u of its patch (Anchor's level 0) is seen at
/// position + shape·u. Where a feature begins its shape is CsdFrame::patch times the identity.
struct AffineState {
  cv::Point2d position;                    ///< working pixels
  cv::Matx22d shape = cv::Matx22d::eye();  ///< working pixels to a sample; determinant > 0
  double scale() const;                    ///< √det shape
};

}  // namespace csd
