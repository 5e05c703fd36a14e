// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <array>
#include <cstddef>

#include "csd/tuning.h"
#include "patch/anchor.h"

namespace csd {

/// Self-similarity of an anchor by direction: how well it fits the tissue around its own position. Zero-mean normalised
/// correlation with the frame at 16 places on each of five rings, 4 to 14 samples away.
class SelfSimilarity {
 public:
  /// `state`: of the anchor of this level in the frame.
  SelfSimilarity(const Pyramid &pyramid, const GlareWeights &weights, const AnchorLevel &anchor, int level,
                 const AffineState &state, const Tuning &tuning);

  /// The best fit within `around` samples of the offset, 0…1. Beyond the rings, the outermost ring counts. 0 if nothing
  /// was measured.
  double near(cv::Vec2d offset, double around) const;
  /// The best fit 9 to 14 samples away, 0…1: near 1 along an edge and in repeated texture.
  double far() const { return far_; }

 private:
  static constexpr std::size_t rings = 5, ways = 16;
  double radius(std::size_t ring) const;  ///< samples
  cv::Vec2d place(std::size_t i) const;   ///< samples from the point, by ring and direction

  std::array<float, rings * ways> fit_{};
  double nearest_ = 0, step_ = 0;  ///< samples: radius of the innermost ring, ring spacing
  double far_ = 0;
};

}  // namespace csd
