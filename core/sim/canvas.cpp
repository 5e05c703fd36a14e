// SPDX-License-Identifier: LGPL-2.1-or-later
#include "sim/canvas.h"

#include <algorithm>
#include <cmath>

#include "sim/ieee_math.h"

namespace csd::sim {
namespace {

std::vector<float> gaussian_weights(double sigma) {
  const int radius = static_cast<int>(std::ceil(2.5 * sigma));
  std::vector<float> w(static_cast<std::size_t>(radius) + 1);  // from the centre outwards
  double sum = 0;
  for (int i = 0; i <= radius; ++i) {
    const double value = exp_of(-i * i / (2 * sigma * sigma));
    w[static_cast<std::size_t>(i)] = static_cast<float>(value);
    sum += i == 0 ? value : 2 * value;
  }
  for (auto &x : w) x = static_cast<float>(x / sum);
  return w;
}

/// out[i] = w·in[i] (begin) or += w·(a[i] + b[i]): loops that compilers vectorise.
void scale_row(const float *in, float w, float *out, int n) {
  for (int i = 0; i < n; ++i) out[i] = w * in[i];
}
void add_rows(const float *a, const float *b, float w, float *out, int n) {
  for (int i = 0; i < n; ++i) out[i] += w * (a[i] + b[i]);
}

}  // namespace

void blur(Canvas &canvas, std::size_t channel, double sigma, std::vector<float> &scratch) {
  if (sigma < 0.2) return;
  const auto w = gaussian_weights(sigma);
  const int radius = static_cast<int>(w.size()) - 1, width = canvas.size().width, height = canvas.size().height;
  const auto row_size = static_cast<std::size_t>(width);
  scratch.resize(row_size * static_cast<std::size_t>(height) + row_size + 2 * static_cast<std::size_t>(radius));
  float *const padded = scratch.data() + row_size * static_cast<std::size_t>(height);
  for (int y = 0; y < height; ++y) {
    const float *in = canvas.row(channel, y);
    std::fill_n(padded, radius, in[0]);
    std::copy_n(in, width, padded + radius);
    std::fill_n(padded + radius + width, radius, in[width - 1]);
    float *out = scratch.data() + static_cast<std::size_t>(y) * row_size;
    scale_row(padded + radius, w[0], out, width);
    for (int k = 1; k <= radius; ++k) {
      add_rows(padded + radius - k, padded + radius + k, w[static_cast<std::size_t>(k)], out, width);
    }
  }
  const auto line = [&](int y) {
    return scratch.data() + static_cast<std::size_t>(std::clamp(y, 0, height - 1)) * row_size;
  };
  for (int y = 0; y < height; ++y) {
    float *out = canvas.row(channel, y);
    scale_row(line(y), w[0], out, width);
    for (int k = 1; k <= radius; ++k) add_rows(line(y - k), line(y + k), w[static_cast<std::size_t>(k)], out, width);
  }
}

}  // namespace csd::sim
