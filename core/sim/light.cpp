// SPDX-License-Identifier: LGPL-2.1-or-later
#include "sim/light.h"

#include <algorithm>
#include <cmath>

#include "sim/ieee_math.h"

namespace csd::sim {
namespace {

constexpr std::uint64_t stream_light = 300, stream_exposure = 310;

/// Shading of a wet, soft body: never fully dark where it faces away. `c` is the cosine to the lamp.
double lambert(double c) {
  c = std::max(c, 0.0);
  return 0.25 + 0.75 * c * c * c;
}

/// log₂ of the exposure: jumps every 2.3 s and settles within a third of a second, with some overshoot.
double exposure_at(double time, std::uint64_t seed) {
  constexpr double every = 2.3;
  const double k = floor_of(time / every), t = (time - k * every) / 0.33;
  const auto value = [&](double n) {
    return n < 1 ? 0.0 : 2 * hashed(seed, stream_exposure, static_cast<std::int64_t>(n)) - 1;
  };
  const double settled = smoothstep(t) + 0.25 * window(t, 0.3, 0.4, 2, 1);
  return 0.6 * lerp(value(k - 1), value(k), settled);
}

}  // namespace

Light::Light(double time, const Effects &effects, std::uint64_t seed, const Camera &camera) {
  const double light = effects[Effect::light];
  follows_ = std::min(light, 1.0);
  falloff_ = effects[Effect::falloff];
  hollow_ = std::min(effects[Effect::cavity], 1.0);
  reference_ = camera.distance;
  lamp_ = camera.centre;
  const auto drift = [&](std::uint64_t i) { return smoothstep(time / 2) * wander(seed, stream_light + i, time / 1.7); };
  if (light > 0) {
    // The lamp moves beside the scope and rolls with it.
    lamp_ += light * camera.distance * 0.22 * (drift(0) * camera.right + drift(1) * camera.down);
    const double power = 1 + 0.2 * light * drift(2), warmth = 0.05 * light * drift(3);
    gain_ = cv::Vec3d(1 - warmth, 1, 1 + warmth) * std::max(power, 0.2);
  }
  if (effects[Effect::exposure] > 0) {
    gain_ *= exp_of(0.69314718055994531 * effects[Effect::exposure] * exposure_at(time, seed));
  }
}

double Light::on(const cv::Vec3d &rest_normal, const cv::Vec3d &normal, const cv::Vec3d &position) const {
  // At rest the lamp is straight above; relief is exaggerated, like under oblique light.
  const double rest = lambert(rest_normal[2]);
  double gain = rest;
  if (follows_ > 0 || falloff_ > 0) {
    const cv::Vec3d to_lamp = lamp_ - position;
    const double distance = std::sqrt(to_lamp.dot(to_lamp));
    if (follows_ > 0) gain = lerp(rest, lambert(normal.dot(to_lamp) / distance), follows_);
    // Inverse square, made steeper because the tissue faces away; relative to the centre's distance, because exposure
    // compensates for the scope's.
    if (falloff_ > 0) gain *= exp_of(-3.5 * 0.69314718055994531 * falloff_ * log2_of(distance / reference_));
  }
  if (hollow_ > 0) {
    // The far end gets half the light of the near walls, like with a scope's auto-exposure.
    const cv::Vec3d to_lamp = lamp_ - position;
    gain *= lerp(1, 2.1 / (1 + std::sqrt(to_lamp.dot(to_lamp)) / nominal_distance), hollow_);
  }
  return gain;
}

}  // namespace csd::sim
