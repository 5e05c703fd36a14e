// SPDX-License-Identifier: LGPL-2.1-or-later
#include "track/likeness.h"

#include <algorithm>
#include <cmath>

#include "track/patch_fit.h"

namespace csd {
namespace {

constexpr double radius[] = {4, 6.5, 9, 11.5, 14};  // samples
constexpr std::size_t first_far = 2;
constexpr double least_weight = 40;  // pixels; of what is mostly masked nothing is known

double correlation(const AnchorLevel &anchor, PatchSample &seen) {
  for (std::size_t i = 0; i < PatchPlane::size; ++i) seen.weight.data[i] *= anchor.weight.data[i];
  const auto m = patch_moments(anchor, seen.value, seen.weight);
  const double scale = m.frame_variance * m.anchor_variance;
  return m.weight >= least_weight && scale > 0 ? m.covariance / std::sqrt(scale) : 0;
}

}  // namespace

/// Every other ring is turned by half a step, so that the places lie evenly.
cv::Vec2d Likeness::place(std::size_t ring, std::size_t way) {
  const double angle = 2 * CV_PI * (static_cast<double>(way) + (ring % 2 != 0 ? 0.5 : 0)) / ways;
  return cv::Vec2d(std::cos(angle), std::sin(angle)) * radius[ring];
}

Likeness::Likeness(const Pyramid &pyramid, const GlareWeights &weights, const AnchorLevel &anchor, int level,
                   const AffineState &state) {
  for (std::size_t ring = 0; ring < rings; ++ring)
    for (std::size_t way = 0; way < ways; ++way) {
      const cv::Vec2d off = state.shape * place(ring, way) * std::ldexp(1.0, level);
      auto seen = sample(pyramid, weights, {state.position + cv::Point2d(off[0], off[1]), state.shape}, level);
      const double fit = correlation(anchor, seen);
      fit_[ring * ways + way] = static_cast<float>(fit);
      if (ring >= first_far) far_ = std::max(far_, fit);
    }
}

double Likeness::near(cv::Vec2d offset, double around) const {
  const double farthest = radius[rings - 1], length = cv::norm(offset);
  if (length > farthest) offset *= farthest / length;
  double best = 0;
  for (std::size_t ring = 0; ring < rings; ++ring)
    for (std::size_t way = 0; way < ways; ++way)
      if (cv::norm(place(ring, way) - offset) <= around) best = std::max(best, double{fit_[ring * ways + way]});
  return best;
}

}  // namespace csd
