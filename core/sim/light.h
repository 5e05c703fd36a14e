// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <opencv2/core.hpp>

#include <cstdint>

#include "sim/camera.h"
#include "sim/scenario.h"

namespace csd::sim {

/// The lamp on the scope and the camera's exposure at one moment.
class Light {
 public:
  Light(double time, const Effects &effects, std::uint64_t seed, const Camera &camera);

  /// The brightness of a piece of tissue. `rest_normal` is its normal at rest; `normal` and `position` are the current
  /// ones, in the scene. Constant for each piece without the effects light and falloff.
  double on(const cv::Vec3d &rest_normal, const cv::Vec3d &normal, const cv::Vec3d &position) const;

  /// Exposure and the lamp's colour, for B, G, R.
  const cv::Vec3d &gain() const { return gain_; }

 private:
  double follows_ = 0, falloff_ = 0, hollow_ = 0;
  cv::Vec3d lamp_;
  double reference_ = 1;  // the distance without falloff
  cv::Vec3d gain_{1, 1, 1};
};

/// Vignetting at a pixel: 1 in the middle, about 0.55 in the corners at strength 1.
inline float vignette(float x, float y, cv::Size size, double strength) {
  const float half_w = 0.5F * static_cast<float>(size.width), half_h = 0.5F * static_cast<float>(size.height);
  const float dx = x + 0.5F - half_w, dy = y + 0.5F - half_h;
  const float r2 = (dx * dx + dy * dy) / (half_w * half_w + half_h * half_h);
  const float gain = 1 - static_cast<float>(strength) * r2 * (0.25F + 0.2F * r2);
  return gain < 0 ? 0 : gain;
}

}  // namespace csd::sim
