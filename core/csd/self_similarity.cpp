// SPDX-License-Identifier: LGPL-2.1-or-later
#include "csd/self_similarity.h"

#include <algorithm>
#include <cmath>

#include "patch/patch_fit.h"

namespace csd {
namespace {

/// Directions by ring and index. Every other ring is rotated by half a step, so that the places are evenly spread.
template <std::size_t rings, std::size_t ways>
const std::array<cv::Vec2d, rings * ways> &directions() {
  static const auto all = [] {
    std::array<cv::Vec2d, rings * ways> out;
    for (std::size_t i = 0; i < out.size(); ++i) {
      const std::size_t ring = i / ways, way = i % ways;
      const double angle = 2 * CV_PI * (static_cast<double>(way) + (ring % 2 != 0 ? 0.5 : 0)) / ways;
      out[i] = {std::cos(angle), std::sin(angle)};
    }
    return out;
  }();
  return all;
}

double fit_of(const AnchorLevel &anchor, PatchSample &seen, double min_weight) {
  PatchPlane tissue;
  weigh_agreement(anchor, seen.weight, tissue);
  const auto all = patch_moments(anchor, seen.value, seen.weight);
  return all.weight >= min_weight ? correlation(all, patch_moments(anchor, seen.value, tissue)) : 0;
}

}  // namespace

SelfSimilarity::SelfSimilarity(const Pyramid &pyramid, const GlareWeights &weights, const AnchorLevel &anchor,
                               int level, const AffineState &state, const Tuning &tuning)
    : nearest_(tuning.self_similarity_nearest), step_(tuning.self_similarity_step) {
  for (std::size_t i = 0; i < fit_.size(); ++i) {
    const cv::Vec2d off = state.shape * place(i) * std::ldexp(1.0, level);
    auto seen = sample(pyramid, weights, {state.position + cv::Point2d(off[0], off[1]), state.shape}, level);
    const double fit = fit_of(anchor, seen, tuning.self_similarity_pixels);
    fit_[i] = static_cast<float>(fit);
    if (radius(i / ways) >= tuning.self_similarity_far) far_ = std::max(far_, fit);
  }
}

double SelfSimilarity::radius(std::size_t ring) const {
  return nearest_ + step_ * static_cast<double>(ring);
}

cv::Vec2d SelfSimilarity::place(std::size_t i) const {
  return directions<rings, ways>()[i] * radius(i / ways);
}

double SelfSimilarity::near(cv::Vec2d offset, double around) const {
  const double farthest = radius(rings - 1), length = cv::norm(offset);
  if (length > farthest) offset *= farthest / length;
  double best = 0;
  for (std::size_t i = 0; i < fit_.size(); ++i)
    if (cv::norm(place(i) - offset) <= around) best = std::max(best, double{fit_[i]});
  return best;
}

}  // namespace csd
