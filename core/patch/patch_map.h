// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <algorithm>
#include <cmath>

#include "image/pyramid.h"
#include "patch/affine_state.h"

namespace csd {

/// Positions of a patch's samples in a pyramid level: sample v at origin + step·v, pixels of that level.
struct PatchMap {
  cv::Point2d origin;
  cv::Matx22d step;
};

/// The pyramid level whose pixel size is nearest to the sample spacing.
inline int matching_level(const AffineState &state, int anchor_level) {
  const double size = std::ldexp(state.scale(), anchor_level);
  return size > 0 ? static_cast<int>(std::clamp(std::round(std::log2(size)), 0., Pyramid::levels - 1.)) : 0;
}

inline PatchMap patch_map(const AffineState &state, int anchor_level, int frame_level) {
  return {state.position * std::ldexp(1., -frame_level), state.shape * std::ldexp(1., anchor_level - frame_level)};
}

}  // namespace csd
