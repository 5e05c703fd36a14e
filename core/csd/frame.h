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

/// A frame as input of `csd`.
struct CsdFrame {
  const Pyramid &pyramid;
  const GlareWeights &weights;
  cv::Size size;                      ///< of the working image
  double unit;                        ///< working pixels per pixel of a 480-line picture, the unit of constants
  double steps = 1;                   ///< frames of 40 ms since the last frame, the unit of rates
  std::int64_t time;                  ///< ns
  std::int64_t training_time;         ///< ns: how long anchor samples are collected
  double patch = 1;                   ///< working pixels per patch sample (21 × 21) for a new point
  FrameBudget budget = {};            ///< when it is spent, points wait
  const WorkFrame *colour = nullptr;  ///< distinguishes tools from tissue for new points; null: no distinction
  const Tuning &tuning = default_tuning;
  SideBySide workers = {};  ///< independent points are tracked in parallel
  bool shows(cv::Point2d p) const {
    return p.x >= -0.5 && p.y >= -0.5 && p.x < size.width - 0.5 && p.y < size.height - 0.5;
  }
};

/// Statistics of the frame over all supporting points.
struct Surroundings {
  double gain_drift = 0, brightness_drift = 0;  ///< median changes of the reliable points
  double blur = 0;                              ///< median of TrackedPoint::blur()
  bool alone = false;                           ///< too few supporting points for a map
};

}  // namespace csd
