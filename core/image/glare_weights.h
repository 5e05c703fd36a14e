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
/// of the room that is left above the surroundings: an absolute threshold masks pale tissue (prototype.md I.2).
/// The marked pixels are dilated; a coarser level holds the mean of what it covers.
class GlareWeights {
 public:
  /// One pass over the working image's colour (luma, where the picture is gray). `forbidden`: CV_8UC1 of the working
  /// size, 255 where there is no tissue (border, burnt-in graphics), weighs 0 too; or empty.
  void build(const WorkFrame &frame, const cv::Mat &forbidden);

  bool empty() const { return levels_[0].empty(); }
  const cv::Mat &level(int l) const { return levels_[static_cast<std::size_t>(l)]; }  ///< CV_8UC1, sizes as Pyramid's

 private:
  std::array<cv::Mat, Pyramid::levels> levels_;
};

}  // namespace csd
