// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <opencv2/core.hpp>

#include <array>
#include <cstdint>

#include "image/pyramid.h"

namespace csd {

class WorkFrame;

/// How far a pixel can be believed, at the pyramid's resolutions: 255 is tissue, 0 is a highlight or its rim.
///
/// A highlight is brighter than what surrounds it, in the least of B, G and R (so that pale tissue is none), by a share
/// of the room that is left above the surroundings: an absolute threshold masks pale tissue.
/// m = min(B, G, R) smoothed by 1 2 1 in both directions; the surroundings: means of m (not smoothed) over cells of 16
/// × 16 pixels at 480 working lines, the forbidden ones left out, median of 5 × 5 cells, bilinear in between; highlight
/// where m − surroundings > `highlight`·(250 − surroundings); dilated by 2 pixels all round, at any height: what leaks
/// from it leaks by the pyramid's smoothing. A pixel of a coarser level lies at every second pixel of the one before
/// and covers half of its neighbours: it holds the mean with weights 1 2 1 in both directions, rounded; the border is
/// mirrored as in Pyramid.
class GlareWeights {
 public:
  /// One pass over the working image's colour (luma, where the picture is gray). `forbidden`: CV_8UC1 of the working
  /// size, 255 where there is no tissue (border, burnt-in graphics), which weighs 0 too, and 0 elsewhere; or empty.
  /// Throws std::invalid_argument where it is something else.
  void build(const WorkFrame &frame, const cv::Mat &forbidden, double highlight = usual_highlight);
  /// With .2 pale relief was masked too: on six clips 1 to 4 % fewer claims.
  static constexpr double usual_highlight = 0.4;

  bool empty() const { return levels_[0].empty(); }
  const cv::Mat &level(int l) const { return levels_[static_cast<std::size_t>(l)]; }  ///< CV_8UC1, sizes as Pyramid's

 private:
  std::array<cv::Mat, Pyramid::levels> levels_;
  cv::Mat least_;  // kept, so that no frame pays for fresh memory
};

}  // namespace csd
