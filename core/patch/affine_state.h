// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <opencv2/core.hpp>

namespace csd {

/// A feature's position and the shape of its surroundings: sample u of its patch (Anchor's level 0) is at position +
/// shape·u. A feature's first shape is CsdFrame::patch times the identity.
struct AffineState {
  cv::Point2d position;                    ///< working pixels
  cv::Matx22d shape = cv::Matx22d::eye();  ///< working pixels to a sample; determinant > 0
  double scale() const;                    ///< √det shape
};

}  // namespace csd
