// SPDX-License-Identifier: LGPL-2.1-or-later
#include "sim/smoke_layer.h"

#include <algorithm>
#include <cmath>

#include "sim/events.h"
#include "sim/ieee_math.h"

namespace csd::sim {
namespace {

constexpr std::uint64_t stream_smoke = 700;
constexpr float cell = 16;                    // pixels at 480 lines
constexpr float colour[3] = {196, 190, 188};  // B, G, R
constexpr double densest = 0.97;

/// Smooth noise in space and time, 0…1.
double cloud(std::uint64_t seed, double x, double y, double t) {
  const double k[3] = {floor_of(x), floor_of(y), floor_of(t)};
  const double f[3] = {smoothstep(x - k[0]), smoothstep(y - k[1]), smoothstep(t - k[2])};
  double result = 0;
  for (int corner = 0; corner < 8; ++corner) {
    std::uint64_t index = 0;  // may wrap
    double weight = 1;
    for (int axis = 0; axis < 3; ++axis) {
      const int up = corner >> axis & 1;
      index = index * 100003 + static_cast<std::uint64_t>(static_cast<std::int64_t>(k[axis]) + up);
      weight *= up != 0 ? f[axis] : 1 - f[axis];
    }
    result += weight * hashed(seed, stream_smoke, static_cast<std::int64_t>(index));
  }
  return result;
}

}  // namespace

SmokeLayer::SmokeLayer(double time, double strength, std::uint64_t seed, cv::Size size)
    : scale_(static_cast<float>(size.height) / 480) {
  const double amount = strength * smoke_density(time);
  if (amount <= 0) return;
  const float pitch = cell * scale_;
  columns_ = static_cast<int>(static_cast<float>(size.width) / pitch) + 2;
  rows_ = static_cast<int>(static_cast<float>(size.height) / pitch) + 2;
  // It rises and drifts; small eddies move with the large ones and change faster.
  const double drift_x = 0.35 * time, drift_y = 0.5 * time;
  for (int j = 0; j < rows_; ++j) {
    for (int i = 0; i < columns_; ++i) {
      const double x = i * cell / 150.0 + drift_x, y = j * cell / 150.0 + drift_y;
      const double c = 0.55 * cloud(seed, x, y, 0.3 * time) + 0.3 * cloud(seed, 2.3 * x, 2.3 * y, 0.6 * time + 50) +
                       0.15 * cloud(seed, 5.1 * x, 5.1 * y, 1.1 * time + 90);
      const double d = 0.78 * amount * (0.12 + 1.3 * clamp01((c - 0.2) / 0.7));
      density_.push_back(static_cast<float>(std::min(d, densest)));
    }
  }
}

float SmokeLayer::density(cv::Point2d pixel) const {
  if (columns_ == 0) return 0;
  const float pitch = cell * scale_;
  const float x = std::clamp(static_cast<float>(pixel.x) / pitch, 0.0F, static_cast<float>(columns_ - 1) - 0.001F);
  const float y = std::clamp(static_cast<float>(pixel.y) / pitch, 0.0F, static_cast<float>(rows_ - 1) - 0.001F);
  const int i = static_cast<int>(x), j = static_cast<int>(y);
  const float fx = x - static_cast<float>(i), fy = y - static_cast<float>(j);
  const float *p = density_.data() + static_cast<std::size_t>(j) * static_cast<std::size_t>(columns_) + i,
              *q = p + columns_;
  return (1 - fy) * (p[0] + fx * (p[1] - p[0])) + fy * (q[0] + fx * (q[1] - q[0]));
}

void SmokeLayer::draw(Canvas &canvas) const {
  if (columns_ == 0) return;
  const int width = canvas.size().width;
  std::vector<float> d(static_cast<std::size_t>(width));
  for (int y = 0; y < canvas.size().height; ++y) {
    for (int x = 0; x < width; ++x) d[static_cast<std::size_t>(x)] = density(cv::Point2d(x, y));
    for (std::size_t c = 0; c < 3; ++c) {
      float *row = canvas.row(c, y);
      for (int x = 0; x < width; ++x) row[x] += d[static_cast<std::size_t>(x)] * (colour[c] - row[x]);
    }
  }
}

}  // namespace csd::sim
