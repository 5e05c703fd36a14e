// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <opencv2/core.hpp>

#include <vector>

#include "sim/canvas.h"
#include "sim/scenario.h"

namespace csd::sim {

/// Focus, and the effect of a lens wipe, at one moment.
class Lens {
 public:
  Lens(double time, const Effects &effects, cv::Size size);

  void draw(Canvas &canvas, std::vector<float> &scratch) const;
  /// The loss of visibility at a pixel: 1 under the cloth, and where the wet lens blurs by 3.5 pixels (at 480 lines).
  float lost(cv::Point2d pixel) const;

 private:
  float cloth(float x) const;

  cv::Size size_;
  double sigma_ = 0;               // of the blur, pixels
  double most_ = 1;                // maximum blur: beyond it everything is lost
  float cloth_at_ = -1, wet_ = 0;  // 0…1 across the picture; 0…1
};

}  // namespace csd::sim
