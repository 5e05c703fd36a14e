// SPDX-License-Identifier: LGPL-2.1-or-later
#include "track/anchor.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "track/patch_kernels.h"
#include "track/patch_map.h"

namespace csd {

namespace {

constexpr int radius = PatchPlane::radius;

std::size_t slot(int level) {
  return static_cast<std::size_t>(level - Anchor::finest);
}

}  // namespace

bool Anchor::has(int level) const {
  return level >= finest && level <= coarsest && levels_[slot(level)];
}

const AnchorLevel &Anchor::level(int level) const {
  return *levels_[slot(level)];
}

void Anchor::set(int level, AnchorLevel &&anchor) {
  levels_[slot(level)] = std::make_unique<AnchorLevel>(anchor);
}

int Anchor::fine_level(double scale) const {
  int best = coarsest;
  while (best > finest && !has(best)) --best;
  for (int l = best; l >= finest && std::ldexp(scale, l) >= .75; --l)
    if (has(l)) best = l;
  return best;
}

PatchSample sample(const Pyramid &pyramid, const GlareWeights &weights, const AffineState &state, int level) {
  const int frame_level = matching_level(state, level);
  const cv::Mat &pixels = pyramid.level(frame_level), &glare = weights.level(frame_level);
  const PatchMap map = patch_map(state, level, frame_level);
  PatchSample out;
  PatchTile tile;
  if (!prepare_tile(pixels, glare, map, tile)) {
    out.inside = scalar::sample_patch(pixels, glare, map, out.value, out.weight);
    return out;
  }
  out.inside = sample_tile(tile, map, out.value, out.weight);
  for (int y = -radius; y < PatchPlane::rows - radius; ++y)
    for (int x = -radius; x < PatchPlane::stride - radius; ++x) {
      const bool padding = x > radius || y > radius;
      if (padding) out.value.at(x, y) = 0;
      if (padding || tile.plain) out.weight.at(x, y) = padding ? 0.F : 1.F;
    }
  return out;
}

AnchorLevel make_anchor_level(const PatchSample &sample) {
  AnchorLevel out;
  out.weight = sample.weight;
  double sum = 0, weight = 0;
  for (std::size_t i = 0; i < PatchPlane::size; ++i) {
    sum += double{sample.weight.data[i]} * sample.value.data[i];
    weight += sample.weight.data[i];
  }
  const auto mean = static_cast<float>(weight > 0 ? sum / weight : 0);
  for (int y = -radius; y <= radius; ++y)
    for (int x = -radius; x <= radius; ++x) {
      out.patch.at(x, y) = sample.value.at(x, y) - mean;
      const int left = std::max(x - 1, -radius), right = std::min(x + 1, radius);
      const int above = std::max(y - 1, -radius), below = std::min(y + 1, radius);
      out.gradient_x.at(x, y) =
          (sample.value.at(right, y) - sample.value.at(left, y)) / static_cast<float>(right - left);
      out.gradient_y.at(x, y) =
          (sample.value.at(x, below) - sample.value.at(x, above)) / static_cast<float>(below - above);
    }
  return out;
}

void AnchorMedian::add(const PatchSample &sample) {
  Compact &c = samples_.emplace_back();
  std::size_t i = 0;
  for (int y = -radius; y <= radius; ++y)
    for (int x = -radius; x <= radius; ++x, ++i) {
      c.value[i] = static_cast<std::uint16_t>(std::lround(std::clamp(sample.value.at(x, y) * 256, 0.F, 65535.F)));
      c.weight[i] = static_cast<std::uint8_t>(std::lround(std::clamp(sample.weight.at(x, y) * 255, 0.F, 255.F)));
    }
}

AnchorLevel AnchorMedian::make() const {
  constexpr std::uint8_t unmasked = 128;
  const std::size_t n = samples_.size();
  const Compact &first = samples_.front();
  // value ≈ gain·first + bias for each sample, least squares with weights 1/(1+(r/c)²)² that follow the residuals.
  std::vector<double> gain(n, 1), bias(n, 0);
  for (std::size_t k = 1; k < n; ++k) {
    const Compact &s = samples_[k];
    std::vector<double> robust(PatchPlane::pixels, 1), size;
    for (int round = 0; round < 5; ++round) {
      double s1 = 0, sF = 0, sFF = 0, sV = 0, sFV = 0;
      for (std::size_t i = 0; i < PatchPlane::pixels; ++i) {
        const double w = robust[i] * std::min(s.weight[i], first.weight[i]);
        const double f = first.value[i] / 256., v = s.value[i] / 256.;
        s1 += w, sF += w * f, sFF += w * f * f, sV += w * v, sFV += w * f * v;
      }
      const double spread = s1 * sFF - sF * sF;
      // Where there is nothing to tell a gain by, the mean alone is brought over.
      gain[k] = spread > 1e-3 * s1 * s1 ? std::clamp((s1 * sFV - sF * sV) / spread, .1, 10.) : 1;
      bias[k] = s1 > 0 ? (sV - gain[k] * sF) / s1 : 0;
      size.clear();
      const auto residual = [&](std::size_t i) {
        return (s.value[i] / 256. - bias[k]) / gain[k] - first.value[i] / 256.;
      };
      for (std::size_t i = 0; i < PatchPlane::pixels; ++i)
        if (std::min(s.weight[i], first.weight[i]) >= unmasked) size.push_back(std::abs(residual(i)));
      if (size.empty()) break;
      const auto middle = size.begin() + static_cast<std::ptrdiff_t>(size.size() / 2);
      std::nth_element(size.begin(), middle, size.end());
      const double c = 3 * std::max(1.48 * *middle, 1.);
      for (std::size_t i = 0; i < PatchPlane::pixels; ++i) {
        const double q = residual(i) / c;
        robust[i] = 1 / ((1 + q * q) * (1 + q * q));
      }
    }
  }

  PatchSample out;
  std::vector<double> values;
  std::size_t i = 0;
  for (int y = -radius; y <= radius; ++y)
    for (int x = -radius; x <= radius; ++x, ++i) {
      values.clear();
      double weight = 0;
      for (std::size_t k = 0; k < n; ++k)
        if (samples_[k].weight[i] >= unmasked) {
          values.push_back((samples_[k].value[i] / 256. - bias[k]) / gain[k]);
          weight += samples_[k].weight[i] / 255.;
        }
      if (3 * values.size() >= n) out.weight.at(x, y) = static_cast<float>(weight / static_cast<double>(values.size()));
      if (values.empty())  // something for the neighbours' gradients
        for (std::size_t k = 0; k < n; ++k) values.push_back((samples_[k].value[i] / 256. - bias[k]) / gain[k]);
      std::sort(values.begin(), values.end());
      const std::size_t m = values.size();
      out.value.at(x, y) = static_cast<float>((values[(m - 1) / 2] + values[m / 2]) / 2);
    }
  return make_anchor_level(out);
}

}  // namespace csd
