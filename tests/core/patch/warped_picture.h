// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <opencv2/core.hpp>

#include <cmath>
#include <cstdint>
#include <functional>
#include <vector>

#include "patch/affine_state.h"

namespace csd::test {

/// A smooth random texture as a formula: waves of random directions, wavelengths and phases. So any affine view of it
/// is known at any point, without resampling.
class Waves {
 public:
  /// Wavelengths in texture units; standard deviation in grey levels.
  Waves(std::uint64_t seed, double shortest, double longest, double deviation, int count = 40) {
    cv::RNG rng(seed * 7919 + 1);
    for (int i = 0; i < count; ++i) {
      const double angle = rng.uniform(0., CV_PI),
                   length = shortest * std::pow(longest / shortest, rng.uniform(0., 1.));
      waves_.push_back({2 * CV_PI / length * std::cos(angle), 2 * CV_PI / length * std::sin(angle),
                        rng.uniform(0., 2 * CV_PI), deviation * std::sqrt(2. / count)});
    }
  }
  double at(double x, double y) const {
    double sum = 0;
    for (const Wave &w : waves_) sum += w.amplitude * std::sin(w.x * x + w.y * y + w.phase);
    return sum;
  }

 private:
  struct Wave {
    double x, y, phase, amplitude;
  };
  std::vector<Wave> waves_;
};

/// A picture that shows the texture's offset u from its origin at state.position + state.shape·u. Its values are
/// gain·texture + bias + noise, rounded.
struct View {
  AffineState state;
  double gain = 1, bias = 128, noise = 0;
  std::uint64_t seed = 1;
  cv::Size size{128, 128};
};

inline cv::Mat render(const Waves &texture, const View &view) {
  cv::RNG rng(view.seed);
  const cv::Matx22d back = view.state.shape.inv();
  cv::Mat out(view.size, CV_8UC1);
  for (int y = 0; y < out.rows; ++y)
    for (int x = 0; x < out.cols; ++x) {
      const cv::Vec2d u = back * cv::Vec2d(x - view.state.position.x, y - view.state.position.y);
      const double v = view.gain * texture.at(u[0], u[1]) + view.bias;
      out.ptr(y)[x] = cv::saturate_cast<std::uint8_t>(v + (view.noise > 0 ? rng.gaussian(view.noise) : 0));
    }
  return out;
}

/// Rotates, then scales, the picture.
inline cv::Matx22d similarity(double degrees, double scale = 1) {
  const double c = scale * std::cos(degrees * CV_PI / 180), s = scale * std::sin(degrees * CV_PI / 180);
  return {c, -s, s, c};
}

}  // namespace csd::test
