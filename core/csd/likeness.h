// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <array>
#include <cstddef>

#include "patch/anchor.h"

namespace csd {

/// How well an anchor fits the tissue around its own place: what tells it apart from its surroundings, by direction.
/// The zero-mean normalised correlation with the frame at 16 places on each of five rings, 4 to 14 samples away.
class Likeness {
 public:
  /// `state`: where the anchor of this level lies in the frame.
  Likeness(const Pyramid &pyramid, const GlareWeights &weights, const AnchorLevel &anchor, int level,
           const AffineState &state);

  /// The best fit within `around` samples of the offset; farther out than the rings reach, of the outermost. 0…1; 0
  /// where nothing was measured.
  double near(cv::Vec2d offset, double around) const;
  /// The best fit 9 to 14 samples away, 0…1: near 1 along an edge and in repeated texture.
  double far() const { return far_; }

 private:
  static constexpr std::size_t rings = 5, ways = 16;
  std::array<float, rings * ways> fit_{};
  double far_ = 0;
};

}  // namespace csd
