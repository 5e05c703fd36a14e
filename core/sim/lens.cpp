// SPDX-License-Identifier: LGPL-2.1-or-later
#include "sim/lens.h"

#include <algorithm>
#include <cmath>

#include "sim/events.h"
#include "sim/ieee_math.h"

namespace csd::sim {
namespace {

constexpr double defocus = 2.2, smear = 7;          // pixels at 480 lines, at strength 1
constexpr float cloth_colour[3] = {188, 196, 208};  // B, G, R
constexpr float cloth_half = 0.32F;                 // of the picture's width
constexpr float veil = 0.25F;                       // how much light a wet lens scatters

/// Defocus: twice in each cycle, and always a trace.
double out_of_focus(double time) {
  return 0.15 + 0.85 * (each_cycle(time, 4.5, 1.2, 8, 1) + each_cycle(time, 13, 0.6, 16, 1.5));
}

}  // namespace

Lens::Lens(double time, const Effects &effects, cv::Size size) : size_(size) {
  const double scale = size.height / 480.0;
  most_ = 3.5 * scale;
  if (effects[Effect::focus_blur] > 0) sigma_ = defocus * effects[Effect::focus_blur] * out_of_focus(time) * scale;
  if (effects[Effect::wipe] > 0) {
    const Wipe wipe = wipe_at(time);
    const double amount = std::min(effects[Effect::wipe], 1.0);
    wet_ = static_cast<float>(amount * wipe.smear);
    sigma_ = std::max(sigma_, smear * amount * wipe.smear * scale);
    cloth_at_ = static_cast<float>(wipe.cover);
  }
}

float Lens::cloth(float x) const {
  const float from_middle = std::abs((x + 0.5F) / static_cast<float>(size_.width) - cloth_at_);
  return smoothstep((cloth_half - from_middle) / (0.4F * cloth_half));
}

float Lens::lost(cv::Point2d pixel) const {
  const float blurred = sigma_ > most_ ? 1.0F : 0.0F;
  return std::max(blurred, cloth(static_cast<float>(pixel.x)));
}

void Lens::draw(Canvas &canvas, std::vector<float> &scratch) const {
  for (std::size_t c = 0; c < 3; ++c) blur(canvas, c, sigma_, scratch);
  const bool has_cloth = cloth_at_ > -cloth_half && cloth_at_ < 1 + cloth_half;
  if (wet_ <= 0 && !has_cloth) return;
  for (std::size_t c = 0; c < 3; ++c) {
    for (int y = 0; y < size_.height; ++y) {
      float *row = canvas.row(c, y);
      for (int x = 0; x < size_.width; ++x) {
        row[x] += veil * wet_ * (cloth_colour[c] - row[x]);
        row[x] += cloth(static_cast<float>(x)) * (cloth_colour[c] - row[x]);
      }
    }
  }
}

}  // namespace csd::sim
