// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <opencv2/core.hpp>

#include <array>
#include <cstddef>
#include <vector>

namespace csd::sim {

/// A picture inside the optics: planes B, G, R of floats, 0…255 within the sensor's range, more in highlights.
class Canvas {
 public:
  void resize(cv::Size size) {
    size_ = size;
    for (auto &p : planes_) p.resize(static_cast<std::size_t>(size.area()));
  }
  cv::Size size() const { return size_; }
  float *row(std::size_t channel, int y) { return planes_[channel].data() + offset(y); }
  const float *row(std::size_t channel, int y) const { return planes_[channel].data() + offset(y); }

 private:
  std::size_t offset(int y) const { return static_cast<std::size_t>(y) * static_cast<std::size_t>(size_.width); }

  cv::Size size_;
  std::array<std::vector<float>, 3> planes_;
};

/// Gaussian blur of one channel by `sigma` pixels, with replicated borders. Does nothing below a sigma of 0.2.
void blur(Canvas &canvas, std::size_t channel, double sigma, std::vector<float> &scratch);

}  // namespace csd::sim
