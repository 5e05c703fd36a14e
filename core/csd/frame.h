// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <opencv2/core.hpp>

#include <cstdint>

#include "content/glare_weights.h"
#include "csd/tuning.h"
#include "image/pyramid.h"
#include "track/frame_budget.h"
#include "track/side_by_side.h"

namespace csd {

class WorkFrame;

/// A frame as `csd` looks at it.
struct CsdFrame {
  const Pyramid &pyramid;
  const GlareWeights &weights;
  cv::Size size;                      ///< of the working image
  double unit;                        ///< working pixels for a pixel of a 480-line picture: what constants are given in
  double steps;                       ///< frames of 40 ms since the last frame: what rates are given in
  std::int64_t time;                  ///< ns
  std::int64_t training_time;         ///< ns: how long an anchor is gathered
  double patch = 1;                   ///< working pixels to a sample of a patch (of 21 × 21) where a point begins
  FrameBudget budget = {};            ///< when it is spent, points wait
  const WorkFrame *colour = nullptr;  ///< tells tools from tissue, where new points begin; none: nothing does
  const Tuning &tuning = default_tuning;
  SideBySide workers = {};  ///< independent points are followed side by side
  bool shows(cv::Point2d p) const {
    return p.x >= -0.5 && p.y >= -0.5 && p.x < size.width - 0.5 && p.y < size.height - 0.5;
  }
};

/// How the supporting points see a frame.
struct Surroundings {
  double gain_drift = 0, brightness_drift = 0;  ///< medians of the sure points' changes
  double blur = 0;                              ///< median of TrackedPoint::blur()
  bool alone = false;                           ///< there are hardly any: a point must do without a map
};

}  // namespace csd
