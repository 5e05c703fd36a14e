// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <opencv2/core.hpp>

#include <cstdint>
#include <vector>

#include "sim/canvas.h"
#include "sim/scenario.h"

namespace csd::sim {

/// From light to bytes: vignette, exposure, noise, soft chroma, the field stop, burnt-in text.
class Sensor {
 public:
  Sensor(const Effects &effects, std::uint64_t seed);

  /// `picture` becomes CV_8UC3, B G R. `gain` is exposure (for B, G, R), `moment` numbers the exposures: another
  /// moment, other noise. The canvas is used up.
  void expose(Canvas &canvas, const cv::Vec3d &gain, std::uint64_t moment, cv::Mat &picture,
              std::vector<float> &scratch) const;

  /// Outside the field stop there is no picture: how much of it is lost at a place (pixels), 0…1.
  float stopped(cv::Point2d pixel, cv::Size size) const;

 private:
  void add_noise(float *b, float *g, float *r, int width, std::uint64_t moment, int y) const;

  double vignette_, noise_, chroma_, stop_;
  std::uint64_t seed_;
  std::vector<float> normal_;  // a reservoir of normal numbers
};

}  // namespace csd::sim
