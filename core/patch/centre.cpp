// SPDX-License-Identifier: LGPL-2.1-or-later
#include "patch/centre.h"

#include <algorithm>

namespace csd {
namespace {

constexpr int reach = 3;
constexpr int samples = (2 * reach + 1) * (2 * reach + 1);
constexpr float min_known = 0.3F;  // share of the anchor that is known there
constexpr double min_noise = 2, outlier = 3;

}  // namespace

std::optional<double> centre_inliers(const AnchorLevel &anchor, const PatchPlane &value, const PatchPlane &weight,
                                     double gain, double bias, double noise) {
  const double c = 1 / (outlier * std::max(noise, min_noise));
  const auto scale = static_cast<float>(c / gain), shift = static_cast<float>(c * bias / gain);
  const auto unit = static_cast<float>(c);
  float known = 0, fits = 0;
  for (int v = -reach; v <= reach; ++v)
    for (int u = -reach; u <= reach; ++u) {
      const float q = scale * value.at(u, v) - shift - unit * anchor.patch.at(u, v);
      known += std::max(anchor.weight.at(u, v), weight.at(u, v));
      fits += weight.at(u, v) / ((1 + q * q) * (1 + q * q));
    }
  if (known < min_known * samples) return {};
  return fits / known;
}

}  // namespace csd
