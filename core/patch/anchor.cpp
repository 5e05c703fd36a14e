// SPDX-License-Identifier: LGPL-2.1-or-later
#include "patch/anchor.h"

#include <algorithm>
#include <cmath>

#include "patch/patch_map.h"
#include "patch/patch_tile.h"

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

void Anchor::set(int level, const AnchorLevel &anchor) {
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
  double sum = 0, tissue = 0, shown = 0;
  for (std::size_t i = 0; i < PatchPlane::size; ++i) {
    out.weight.data[i] = GlareWeights::tissue_share(sample.weight.data[i]);
    out.shown.data[i] = GlareWeights::shown_share(sample.weight.data[i]);
    sum += double{out.shown.data[i]} * sample.value.data[i];
    tissue += out.weight.data[i];
    shown += out.shown.data[i];
  }
  out.tissue_share = tissue / PatchPlane::pixels;
  out.shown_share = shown / PatchPlane::pixels;
  const auto mean = static_cast<float>(shown > 0 ? sum / shown : 0);
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

void weigh_agreement(const AnchorLevel &anchor, PatchPlane &weight, PatchPlane &tissue) {
  for (std::size_t i = 0; i < PatchPlane::size; ++i) {
    const float seen = GlareWeights::tissue_share(weight.data[i]), known = anchor.weight.data[i];
    const float shown = anchor.shown.data[i] * GlareWeights::shown_share(weight.data[i]);
    weight.data[i] = (1 - std::abs(seen - known)) * shown;
    tissue.data[i] = seen * known;
  }
}

}  // namespace csd
