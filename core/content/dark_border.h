// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <opencv2/core.hpp>

namespace csd {

/// Finds the dark border joined to the frame's edge: the field stop of a round or D-shaped endoscope picture, pillar
/// box and letter box, with whatever is written into them.
///
/// Works on a small copy of the picture. What counts is what is dark in nearly all frames of the last second or two, so
/// that a dark tool that comes in over the edge does not; light is believed sooner than dark. A frame that is dark all
/// over (the endoscope in its sleeve) says nothing, unless none before was lit: then all of it is border.
class DarkBorder {
 public:
  /// Takes the next frame: CV_8UC1, working luma; `dt` seconds after the one before (any value for the first).
  /// Returns whether mask() is not what it was. A change of size starts anew.
  bool update(const cv::Mat &luma, double dt);

  /// CV_8UC1, 255 on the border, a fraction of the luma's size (the same field of view); not grown by a patch, but
  /// holds every pixel that the border touches.
  const cv::Mat &mask() const { return mask_; }
  /// Whether there was a frame that was not wholly dark.
  bool lit() const { return lit_; }

  void reset();

 private:
  void decide();

  cv::Size luma_size_;
  bool lit_ = false;    // a frame that is not dark all over was seen
  cv::Mat small_;       // CV_8UC1
  cv::Mat dark_share_;  // CV_32FC1: share of the recent past in which the pixel was dark
  cv::Mat dark_;        // CV_8UC1: is held to be dark
  cv::Mat mask_;
};

}  // namespace csd
