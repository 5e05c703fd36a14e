// SPDX-License-Identifier: LGPL-2.1-or-later
#include "track/anchor.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "track/patch_map.h"
#include "track/patch_tile.h"

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

int Anchor::fine_level(double zoom) const {
  int best = coarsest;
  while (best > finest && !has(best)) --best;
  for (int l = best; l >= finest && std::ldexp(zoom, l) >= .75; --l)
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
    out.inside = sample_scalar(pixels, glare, map, out.value, out.weight);
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

namespace {

/// Gain and bias of a sample against the first: value ≈ gain·first + bias.
struct Brightness {
  double gain = 1, bias = 0;
};

double median(std::vector<double> &values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

/// Least squares with weights 1/(1+(r/c)²)² that follow the residuals. It begins with medians, for a highlight in both
/// has more leverage than all the texture. `value`, `first`: grey levels, where both count.
Brightness compare(const std::vector<double> &value, const std::vector<double> &first) {
  const std::size_t n = value.size();
  Brightness b;
  if (n == 0) return b;
  std::vector<double> size(n);
  const auto middle_and_spread = [&size](const std::vector<double> &v) {
    size = v;
    const double middle = median(size);
    for (double &s : size) s = std::abs(s - middle);
    return std::pair(middle, median(size));
  };
  const auto [middle, spread_of_value] = middle_and_spread(value);
  const auto [first_middle, spread_of_first] = middle_and_spread(first);
  if (spread_of_first > .1) b.gain = std::clamp(spread_of_value / spread_of_first, .1, 10.);
  b.bias = middle - b.gain * first_middle;
  for (int round = 0; round < 10; ++round) {
    const auto residual = [&](std::size_t i) { return (value[i] - b.bias) / b.gain - first[i]; };
    for (std::size_t i = 0; i < n; ++i) size[i] = std::abs(residual(i));
    const double c = 3 * std::max(1.48 * median(size), 1.);
    double s1 = 0, sF = 0, sFF = 0, sV = 0, sFV = 0;
    for (std::size_t i = 0; i < n; ++i) {
      const double q = residual(i) / c, w = 1 / ((1 + q * q) * (1 + q * q)), f = first[i], v = value[i];
      s1 += w, sF += w * f, sFF += w * f * f, sV += w * v, sFV += w * f * v;
    }
    const double spread = s1 * sFF - sF * sF;
    // Where there is nothing to tell a gain by, the mean alone is brought over.
    b.gain = spread > 1e-3 * s1 * s1 ? std::clamp((s1 * sFV - sF * sV) / spread, .1, 10.) : 1;
    b.bias = (sV - b.gain * sF) / s1;
  }
  return b;
}

}  // namespace

AnchorLevel AnchorMedian::make() const {
  constexpr std::uint8_t unmasked = 128;
  const std::size_t n = samples_.size();
  const Compact &first = samples_.front();
  std::vector<Brightness> brightness(n);
  std::vector<double> both[2];
  for (std::size_t k = 1; k < n; ++k) {
    for (auto &b : both) b.clear();
    for (std::size_t i = 0; i < PatchPlane::pixels; ++i)
      if (std::min(samples_[k].weight[i], first.weight[i]) >= unmasked) {
        both[0].push_back(samples_[k].value[i] / 256.);
        both[1].push_back(first.value[i] / 256.);
      }
    brightness[k] = compare(both[0], both[1]);
  }
  const auto value = [&](std::size_t k, std::size_t i) {
    return (samples_[k].value[i] / 256. - brightness[k].bias) / brightness[k].gain;
  };

  PatchSample out;
  std::vector<double> values;
  std::size_t i = 0;
  for (int y = -radius; y <= radius; ++y)
    for (int x = -radius; x <= radius; ++x, ++i) {
      values.clear();
      double weight = 0;
      for (std::size_t k = 0; k < n; ++k)
        if (samples_[k].weight[i] >= unmasked) {
          values.push_back(value(k, i));
          weight += samples_[k].weight[i] / 255.;
        }
      if (3 * values.size() >= n) out.weight.at(x, y) = static_cast<float>(weight / static_cast<double>(values.size()));
      if (values.empty())  // something for the neighbours' gradients
        for (std::size_t k = 0; k < n; ++k) values.push_back(value(k, i));
      std::sort(values.begin(), values.end());
      const std::size_t m = values.size();
      out.value.at(x, y) = static_cast<float>((values[(m - 1) / 2] + values[m / 2]) / 2);
    }
  return make_anchor_level(out);
}

}  // namespace csd
