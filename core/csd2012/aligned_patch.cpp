// SPDX-License-Identifier: LGPL-2.1-or-later
#include "csd2012/aligned_patch.h"

#include <algorithm>

namespace csd {
namespace {
constexpr int coarser = 1;  // levels above the finest that the frame shows, for coarse-to-fine alignment
}

AlignedPatch::AlignedPatch(const Pyramid &pyramid, const GlareWeights &weights, cv::Point2d position, double pixel)
    : shape_(cv::Matx22d::eye() * pixel), pixel_(pixel) {
  for (int level = 0; level <= Anchor::coarsest; ++level)
    anchor_.set(level, make_anchor_level(sample(pyramid, weights, {position, shape_}, level)));
}

AlignedPatch::Fit AlignedPatch::fit(const Pyramid &pyramid, const GlareWeights &weights, cv::Point2d position) const {
  Fit fit{{position, shape_}};
  const int finest = anchor_.fine_level(fit.state.scale() / pixel_);
  for (int level = std::min(finest + coarser, Anchor::coarsest); level >= finest; --level) {
    const bool last = level == finest;
    const auto seen =
        align(pyramid, weights, anchor_.level(level), level, fit.state, {},
              last ? AlignModel::affine : AlignModel::similarity, last ? fine_precision : coarse_precision);
    if (!seen.usable) continue;
    fit.state = seen.state;
    if (last) fit.zncc = seen.zncc;
  }
  return fit;
}

}  // namespace csd
