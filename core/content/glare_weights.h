// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <opencv2/core.hpp>

#include <algorithm>
#include <array>
#include <cstdint>

#include "image/pyramid.h"

namespace csd {

class WorkFrame;

/// What each pixel shows, at the pyramid's resolutions: 255: tissue; 128: what may be a highlight, or its rim; 0:
/// nothing (forbidden, or clipped: m ≥ 250). A mixture lies between: tissue_share() and shown_share() take it apart.
///
/// Brightness alone does not make a highlight: bright dots of a texture pass for one, too. But a highlight moves with
/// the lamp and the lens, and texture with the tissue. So an alignment weighs a pixel by whether picture and anchor
/// agree (weigh_agreement()). A clipped pixel has no texture: under changing light, counting it put points .05 px off.
///
/// A highlight exceeds its surroundings in the smallest of B, G and R (so that pale tissue is not one) by a share of
/// the room left above them: an absolute threshold would mask pale tissue. m = min(B, G, R), smoothed by 1 2 1 in both
/// directions. The surroundings are means of unsmoothed m over cells of 16 × 16 pixels at 480 working lines, without
/// forbidden pixels, then a median of 5 × 5 cells, interpolated bilinearly. Highlight if m − surroundings >
/// `highlight`·(250 − surroundings); dilated by 2 pixels at any height, because it spreads by the pyramid's smoothing.
/// A pixel of a coarser level lies at every second pixel of the previous one and covers half of its neighbours. It is
/// the mean with weights 1 2 1 in both directions, rounded; the border is mirrored as in Pyramid.
class GlareWeights {
 public:
  static constexpr std::uint8_t tissue = 255, highlight = 128, nothing = 0;

  /// One pass over the working image's colour (luma if the picture is gray). `forbidden`: empty, or CV_8UC1 of the
  /// working size, 255 where there is no tissue (border, burnt-in graphics) and 0 elsewhere.
  /// Throws std::invalid_argument on another type or size.
  void build(const WorkFrame &frame, const cv::Mat &forbidden, double highlight = usual_highlight);
  /// With .2 pale relief is masked too: 1 to 4 % fewer claims on six clips.
  static constexpr double usual_highlight = 0.4;

  /// Shares of tissue, and of what is not forbidden, at a pixel or sample of this value / 255, 0…1. Of a highlight
  /// exactly nothing is tissue: its contrast is such that .4 % of it would be seen. Half tissue, half forbidden passes
  /// for a highlight; `forbidden` reaches beyond the field's edge by half a patch, so such pixels show tissue.
  static constexpr float tissue_share(float value) {
    constexpr float of_highlight = highlight / 255.F;
    return std::max(0.F, (value - of_highlight) / (1 - of_highlight));
  }
  static constexpr float shown_share(float value) { return std::min(1.F, value * 255 / highlight); }

  bool empty() const { return levels_[0].empty(); }
  const cv::Mat &level(int l) const { return levels_[static_cast<std::size_t>(l)]; }  ///< CV_8UC1, sizes as Pyramid's

 private:
  std::array<cv::Mat, Pyramid::levels> levels_;
  cv::Mat least_;  // kept to avoid allocations
};

}  // namespace csd
