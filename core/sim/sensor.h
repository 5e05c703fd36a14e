// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <opencv2/core.hpp>

#include <cstdint>
#include <vector>

#include "sim/canvas.h"
#include "sim/scenario.h"

namespace csd::sim {

/// Converts light to bytes: vignette, exposure, noise, soft chroma, the field stop, burnt-in text.
class Sensor {
 public:
  Sensor(const Effects &effects, std::uint64_t seed);

  /// `picture` becomes CV_8UC3, B G R. `gain` is exposure (for B, G, R). `moment` is the number of the exposure, which
  /// selects the noise. Uses up the canvas.
  void expose(Canvas &canvas, const cv::Vec3d &gain, std::uint64_t moment, cv::Mat &picture,
              std::vector<float> &scratch) const;

  /// The loss of visibility at a pixel, 0…1: there is no picture outside the field stop.
  float stopped(cv::Point2d pixel, cv::Size size) const;

 private:
  void add_noise(float *b, float *g, float *r, int width, std::uint64_t moment, int y) const;

  double vignette_, noise_, chroma_, stop_;
  std::uint64_t seed_;
  std::vector<float> normal_;  // a reservoir of normal numbers
};

}  // namespace csd::sim
