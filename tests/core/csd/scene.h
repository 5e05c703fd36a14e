// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <opencv2/imgproc.hpp>

#include "base/types.h"
#include "csd/frame.h"
#include "csd/neighbour_map.h"
#include "track/moving_scene.h"

namespace csd {

/// Frames of 320 × 240, 40 ms apart, as csd sees them: a moving texture. One of their pixels is two px of 480 lines.
class Scene {
 public:
  cv::Mat picture(cv::Point2d shift) const {
    cv::Mat luma;
    cv::cvtColor(scene_.render(shift), luma, cv::COLOR_BGR2GRAY);
    return luma;
  }
  CsdFrame frame(cv::Point2d shift) { return show(picture(shift)); }
  CsdFrame show(const cv::Mat &luma, const Tuning &tuning = default_tuning) {
    pyramid_.build(luma);
    return {.pyramid = pyramid_,
            .weights = glare_,
            .size = luma.size(),
            .unit = 0.5,
            .time = time_ += second / 25,
            .training_time = second / 2,
            .tuning = tuning};
  }
  /// Maps of neighbours that move by `shift` from their reference coordinates.
  static NeighbourMap neighbours(cv::Point2d shift) {
    NeighbourMap map;
    map.shift = shift;
    map.spread = 0.25;
    map.support = 14;
    return map;
  }

 private:
  MovingScene scene_;
  Pyramid pyramid_;
  GlareWeights glare_;
  std::int64_t time_ = 0;
};

}  // namespace csd
