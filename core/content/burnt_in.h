// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <opencv2/core.hpp>

namespace csd {

/// Finds text and logos burnt into the picture: sharp edges that stay fixed while their surroundings move.
///
/// For each pixel of a copy of at most 288 lines it keeps the recent mean intensity and the mean deviation from it.
/// Deviation over gradient is the motion of an edge in pixels. Fixed edges are graphics if most of the texture on all
/// their sides moves, as far as the lit picture reaches. If one side is still too (static tissue, also beside a moving
/// tool), the result is open.
class BurntIn {
 public:
  /// Adds a sample: CV_8UC1, working luma, `dt` seconds after the previous one (any value for the first). A few samples
  /// a second suffice. Returns whether mask() has changed. A change of size restarts it.
  bool update(const cv::Mat &luma, double dt);

  /// CV_8UC1, 255 on the edges of graphics, a fraction of the luma's size (the same field of view); not dilated.
  const cv::Mat &mask() const { return mask_; }

  void reset();

 private:
  struct Blocks;
  class Surroundings;
  void accumulate(double dt);
  float noise();
  Blocks sum_blocks(float noise);
  void weigh(const Blocks &blocks, double dt);
  bool mark();

  cv::Size luma_size_;
  int block_ = 0;    // side of a block, px of the copy
  double seen_ = 0;  // s, duration of the samples so far
  int samples_ = 0;
  cv::Mat copy_;       // CV_8UC1, the picture
  cv::Mat mean_;       // CV_32FC1, grey levels
  cv::Mat deviation_;  // CV_32FC1, grey levels
  cv::Mat gradient_;   // CV_32FC1, of mean_: grey levels over two pixels, the larger of both directions
  cv::Mat fixed_;      // CV_8UC1, 255: a sharp edge that is fixed
  cv::Mat evidence_;   // CV_32FC1, per block: seconds for which it was graphics
  cv::Mat marked_;     // CV_8UC1, per block
  cv::Mat mask_;
};

}  // namespace csd
