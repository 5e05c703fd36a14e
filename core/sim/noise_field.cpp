// SPDX-License-Identifier: LGPL-2.1-or-later
#include "sim/noise_field.h"

#include <algorithm>
#include <cmath>

#include "sim/ieee_math.h"

namespace csd::sim {

NoiseField NoiseField::doubled() const {
  // Cubic B-spline subdivision: new samples are [1 6 1]/8 on the old ones and [1 1]/2 between them.
  const int n = side_;
  NoiseField across(2 * n), result(2 * n);
  for (int y = 0; y < n; ++y) {
    const float *in = row(y);
    float *out = across.row(y);
    for (int x = 0; x < n; ++x) {
      const float before = in[x > 0 ? x - 1 : n - 1], after = in[x + 1 < n ? x + 1 : 0];
      out[2 * x] = 0.125F * (before + after) + 0.75F * in[x];
      out[2 * x + 1] = 0.5F * (in[x] + after);
    }
  }
  for (int y = 0; y < n; ++y) {
    const float *before = across.row(y > 0 ? y - 1 : n - 1), *in = across.row(y),
                *after = across.row(y + 1 < n ? y + 1 : 0);
    float *even = result.row(2 * y), *odd = result.row(2 * y + 1);
    for (int x = 0; x < 2 * n; ++x) {
      even[x] = 0.125F * (before[x] + after[x]) + 0.75F * in[x];
      odd[x] = 0.5F * (in[x] + after[x]);
    }
  }
  return result;
}

void NoiseField::normalise() {
  double sum = 0, squares = 0;
  for (const float x : data_) {
    sum += x;
    squares += static_cast<double>(x) * x;
  }
  const double n = static_cast<double>(data_.size()), mean = sum / n;
  const double deviation = std::sqrt(std::max(squares / n - mean * mean, 0.0));
  const auto scale = static_cast<float>(deviation > 1e-12 ? 1 / deviation : 0);
  for (float &x : data_) x = (x - static_cast<float>(mean)) * scale;
}

NoiseField fractal_noise(int side, const std::vector<Octave> &octaves, std::uint64_t seed, std::uint64_t stream) {
  // Coarse to fine: each resolution adds the blobs of about four samples.
  Random random(seed, stream);
  NoiseField field(std::min(side, 4));
  for (;; field = field.doubled()) {
    const double sample = static_cast<double>(side) / field.side();
    for (const Octave &o : octaves) {
      const double blob = o.size / sample;  // in samples of this resolution
      // A smoothed lattice of random numbers has blobs of about two samples.
      if ((blob >= 1.4142 && blob < 2.8284) || (field.side() == side && blob < 1.4142)) {
        for (float &x : field.values()) x += static_cast<float>(o.weight * random.normal());
      }
    }
    if (field.side() == side) break;
  }
  field.normalise();
  return field;
}

Cells cells(int side, double size, double jitter, std::uint64_t seed, std::uint64_t stream) {
  const int n = 2 * std::max(1, static_cast<int>(floor_of(side / size / 2 + 0.5)));  // even, because rows come in pairs
  const auto pitch = static_cast<float>(side) / static_cast<float>(n);
  struct Site {
    float x, y, value;
  };
  std::vector<Site> sites(static_cast<std::size_t>(n) * static_cast<std::size_t>(n));
  Random random(seed, stream);
  for (int j = 0; j < n; ++j) {
    for (int i = 0; i < n; ++i) {
      // Shifts every second row by half a cell: cells get six neighbours, like lobules.
      const double x = i + 0.25 + 0.5 * (j % 2) + jitter * (random.uniform() - 0.5);
      const double y = j + 0.5 + jitter * (random.uniform() - 0.5);
      sites[static_cast<std::size_t>(j * n + i)] = {static_cast<float>(x), static_cast<float>(y),
                                                    static_cast<float>(random.uniform())};
    }
  }
  Cells result{NoiseField(side), NoiseField(side)};
  for (int y = 0; y < side; ++y) {
    const float py = (static_cast<float>(y) + 0.5F) / pitch;
    const int cy = static_cast<int>(py);
    for (int x = 0; x < side; ++x) {
      const float px = (static_cast<float>(x) + 0.5F) / pitch;
      const int cx = static_cast<int>(px);
      float nearest = 1e9F, second = 1e9F, value = 0;
      for (int j = cy - 1; j <= cy + 1; ++j) {
        const int wrapped_j = j < 0 ? j + n : j >= n ? j - n : j;
        const float shift_y = static_cast<float>(j - wrapped_j) - py;
        for (int i = cx - 2; i <= cx + 1; ++i) {
          const int wrapped_i = i < 0 ? i + n : i >= n ? i - n : i;
          const Site &s = sites[static_cast<std::size_t>(wrapped_j * n + wrapped_i)];
          const float dx = s.x + static_cast<float>(i - wrapped_i) - px, dy = s.y + shift_y;
          const float d = dx * dx + dy * dy;
          if (d < nearest) {
            second = nearest;
            nearest = d;
            value = s.value;
          } else {
            second = std::min(second, d);
          }
        }
      }
      result.edge.row(y)[x] = std::sqrt(second) - std::sqrt(nearest);
      result.value.row(y)[x] = value;
    }
  }
  return result;
}

}  // namespace csd::sim
