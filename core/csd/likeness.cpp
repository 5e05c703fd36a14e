// SPDX-License-Identifier: LGPL-2.1-or-later
#include "csd/likeness.h"

#include <algorithm>
#include <cmath>

#include "patch/patch_fit.h"

namespace csd {
namespace {

constexpr double radius[] = {4, 6.5, 9, 11.5, 14};  // samples
constexpr std::size_t first_far = 2;
constexpr double least_weight = 40;  // pixels; of what is mostly masked nothing is known

/// Every other ring is turned by half a step, so that the places lie evenly. Samples, by ring and way.
template <std::size_t rings, std::size_t ways>
const std::array<cv::Vec2d, rings * ways> &places() {
  static const auto all = [] {
    std::array<cv::Vec2d, rings * ways> out;
    for (std::size_t i = 0; i < out.size(); ++i) {
      const std::size_t ring = i / ways, way = i % ways;
      const double angle = 2 * CV_PI * (static_cast<double>(way) + (ring % 2 != 0 ? 0.5 : 0)) / ways;
      out[i] = cv::Vec2d(std::cos(angle), std::sin(angle)) * radius[ring];
    }
    return out;
  }();
  return all;
}

double correlation(const AnchorLevel &anchor, PatchSample &seen) {
  for (std::size_t i = 0; i < PatchPlane::size; ++i) seen.weight.data[i] *= anchor.weight.data[i];
  const auto m = patch_moments(anchor, seen.value, seen.weight);
  const double scale = m.frame_variance * m.anchor_variance;
  return m.weight >= least_weight && scale > 0 ? m.covariance / std::sqrt(scale) : 0;
}

}  // namespace

Likeness::Likeness(const Pyramid &pyramid, const GlareWeights &weights, const AnchorLevel &anchor, int level,
                   const AffineState &state) {
  for (std::size_t i = 0; i < fit_.size(); ++i) {
    const cv::Vec2d off = state.shape * places<rings, ways>()[i] * std::ldexp(1.0, level);
    auto seen = sample(pyramid, weights, {state.position + cv::Point2d(off[0], off[1]), state.shape}, level);
    const double fit = correlation(anchor, seen);
    fit_[i] = static_cast<float>(fit);
    if (i / ways >= first_far) far_ = std::max(far_, fit);
  }
}

double Likeness::near(cv::Vec2d offset, double around) const {
  const double farthest = radius[rings - 1], length = cv::norm(offset);
  if (length > farthest) offset *= farthest / length;
  double best = 0;
  for (std::size_t i = 0; i < fit_.size(); ++i)
    if (cv::norm(places<rings, ways>()[i] - offset) <= around) best = std::max(best, double{fit_[i]});
  return best;
}

}  // namespace csd
