// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <opencv2/core.hpp>

#include <cstdint>
#include <vector>

#include "sim/canvas.h"

namespace csd::sim {

/// Smoke between the scope and the tissue at one moment: P' = (1−d)·P + d·C, the meaning of Eq. 1, with a density d
/// that varies smoothly over the picture and drifts.
class SmokeLayer {
 public:
  SmokeLayer(double time, double strength, std::uint64_t seed, cv::Size size);

  void draw(Canvas &canvas) const;
  /// d at a pixel, 0…0.97.
  float density(cv::Point2d pixel) const;

 private:
  float scale_;
  int columns_ = 0, rows_ = 0;  // none: no smoke
  std::vector<float> density_;
};

}  // namespace csd::sim
