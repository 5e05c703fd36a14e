// SPDX-License-Identifier: LGPL-2.1-or-later
#include "sim/highlights.h"

#include <algorithm>
#include <cmath>

#include "sim/ieee_math.h"
#include "sim/noise_field.h"

namespace csd::sim {
namespace {

constexpr int side = 256;
constexpr float texels_per_unit = 0.5F;  // so the relief repeats every 512 units
constexpr float steepest = 0.3F;         // of the fine relief
constexpr float glow_width = 2.2F;       // of a core's radius

}  // namespace

Highlights::Highlights(double strength, std::uint64_t seed) {
  if (strength <= 0) return;
  radius_ = 0.075F * static_cast<float>(std::sqrt(strength));
  const NoiseField field = fractal_noise(side, {{15, 1}, {6, 0.22}}, seed, 500);
  float max_slope_squared = 0;
  relief_.resize(static_cast<std::size_t>(side) * side);
  for (int y = 0; y < side; ++y) {
    for (int x = 0; x < side; ++x) {
      const Slope s{field.at(x + 1, y) - field.at(x - 1, y), field.at(x, y + 1) - field.at(x, y - 1)};
      relief_[static_cast<std::size_t>(y * side + x)] = s;
      max_slope_squared = std::max(max_slope_squared, s.x * s.x + s.y * s.y);
    }
  }
  const float scale = steepest / std::sqrt(max_slope_squared);
  for (Slope &s : relief_) s = {s.x * scale, s.y * scale};
  reach_ = steepest + glow_width * 1.5F * radius_;
}

Highlights::Slope Highlights::relief(float u, float v) const {
  const float x = u * texels_per_unit + 64 * side, y = v * texels_per_unit + 64 * side;
  const int ix = static_cast<int>(x), iy = static_cast<int>(y);
  const float fx = x - static_cast<float>(ix), fy = y - static_cast<float>(iy);
  const auto at = [this](int i, int j) {
    return relief_[static_cast<std::size_t>(j & (side - 1)) * side + static_cast<std::size_t>(i & (side - 1))];
  };
  const Slope a = at(ix, iy), b = at(ix + 1, iy), c = at(ix, iy + 1), d = at(ix + 1, iy + 1);
  const auto mix = [&](float p, float q, float r, float s) {
    const float top = p + fx * (q - p), bottom = r + fx * (s - r);
    return top + fy * (bottom - top);
  };
  return {mix(a.x, b.x, c.x, d.x), mix(a.y, b.y, c.y, d.y)};
}

Highlights::Value Highlights::at(const Fragment &f, float slope_x, float slope_y, float gloss) const {
  if (radius_ <= 0) return {};
  // In camera coordinates the normal has the components −slope/√(1+slope²).
  const float w = 1 / std::sqrt(1 + slope_x * slope_x + slope_y * slope_y);
  float x = f[Fragment::normal_x] + slope_x * w, y = f[Fragment::normal_y] + slope_y * w;
  if (x * x + y * y > reach_ * reach_) return {};
  const Slope s = relief(f[Fragment::u], f[Fragment::v]);
  x += s.x;
  y += s.y;
  const float radius = radius_ * gloss, r2 = radius * radius, d2 = x * x + y * y;
  if (d2 >= r2 * (glow_width * glow_width)) return {};
  const float glow = 1 - d2 / (r2 * (glow_width * glow_width));
  return {smoothstep(1.3F * (1 - d2 / r2)), glow * glow};
}

}  // namespace csd::sim
