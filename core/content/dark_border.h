// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <opencv2/core.hpp>

namespace csd {

/// Finds the dark border joined to the frame's edge: the field stop of a round or D-shaped endoscope picture, pillar
/// box and letter box, including text in them.
///
/// Works on a small copy of the picture. A pixel counts as dark if it was dark in nearly all frames of the last second
/// or two, so that a dark tool that enters over the edge does not. Light is accepted sooner than dark. A frame that is
/// dark all over (the endoscope in its sleeve) is ignored, unless none before was lit: then all of it is border.
class DarkBorder {
 public:
  /// Adds the next frame: CV_8UC1, working luma, `dt` seconds after the previous one (any value for the first). Returns
  /// whether mask() has changed. A change of size restarts it.
  bool update(const cv::Mat &luma, double dt);

  /// CV_8UC1, 255 on the border, a fraction of the luma's size (the same field of view). Contains every pixel that the
  /// border touches; not dilated by a patch.
  const cv::Mat &mask() const { return mask_; }
  /// Whether any frame was not entirely dark.
  bool lit() const { return lit_; }

  void reset();

 private:
  void decide();

  cv::Size luma_size_;
  bool lit_ = false;    // a frame that is not entirely dark was seen
  cv::Mat small_;       // CV_8UC1
  cv::Mat dark_share_;  // CV_32FC1: share of the recent frames in which the pixel was dark
  cv::Mat dark_;        // CV_8UC1: classified as dark
  cv::Mat mask_;
};

}  // namespace csd
