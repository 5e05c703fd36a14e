// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <opencv2/core.hpp>

#include <vector>

namespace csd {

/// The recursive tracker of §2.1.1: pyramidal Lucas–Kanade from each frame to the next. The point found becomes the
/// next frame's query, which is the "template update" of the paper.
///
/// Window as large as the patch, at most 3 levels above the picture, 30 iterations or 0.01 px, minimal eigenvalue 1e-4.
class RecursiveTracker {
 public:
  /// `window`: odd side of the window in working pixels.
  void set_window(int window) { window_ = window; }

  /// Moves each of `points` (working pixels) from the frame that was kept into `luma`. found[i] is 0 where LK fails.
  /// Without a frame kept, or with one of another size, nothing is found. A frame that was kept serves once: who could
  /// not keep `luma`, where the points are now, finds nothing next. Throws cv::Exception, std::bad_alloc, and has moved
  /// nothing then.
  void track(const cv::Mat &luma, std::vector<cv::Point2f> &points, std::vector<unsigned char> &found);
  /// Keeps `luma` (copied into a pyramid) as the frame to track from; free if track() has just seen it.
  void keep(const cv::Mat &luma);
  /// Without points to follow no pyramid is made: call instead of keep().
  void skip();

 private:
  void build(const cv::Mat &luma);

  int window_ = 21;
  std::vector<cv::Mat> kept_, current_;
  bool kept_valid_ = false, current_valid_ = false;
};

}  // namespace csd
