// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <opencv2/core.hpp>

namespace csd {

/// Finds text and logos that are burnt into the picture: sharp edges that stay put while what is around them moves.
///
/// For every pixel of a copy of at most 288 lines it keeps the recent mean intensity and the mean deviation from it.
/// Deviation over gradient is how far the edge moves, in pixels. Edges that do not move are graphics when on
/// all sides of them, as far as the lit picture goes, most of what has texture does move; where one side stands still
/// too (static tissue, also beside a moving tool), nothing is concluded.
class BurntIn {
 public:
  /// Takes the next sample: CV_8UC1, working luma; `dt` seconds after the one before (any value for the first). A few
  /// samples a second are enough. Returns whether mask() is not what it was. A change of size starts anew.
  bool update(const cv::Mat &luma, double dt);

  /// CV_8UC1, 255 on the edges of graphics, a fraction of the luma's size (the same field of view); not grown.
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
  double seen_ = 0;  // s of samples so far
  int samples_ = 0;
  cv::Mat copy_;       // CV_8UC1, the picture
  cv::Mat mean_;       // CV_32FC1, grey levels
  cv::Mat deviation_;  // CV_32FC1, grey levels
  cv::Mat gradient_;   // CV_32FC1, of mean_: grey levels over two pixels, the larger of the two directions
  cv::Mat fixed_;      // CV_8UC1, 255: a sharp edge that does not move
  cv::Mat evidence_;   // CV_32FC1, a block each: seconds for which it was graphics
  cv::Mat marked_;     // CV_8UC1, a block each
  cv::Mat mask_;
};

}  // namespace csd
