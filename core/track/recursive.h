// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <opencv2/core.hpp>

#include <vector>

namespace csd {

/// The recursive tracker of §2.1.1: pyramidal Lucas–Kanade from frame to frame. Each found position starts the next
/// frame's search, which is the "template update" of the paper.
///
/// Window of the patch's size, at most 3 levels above the picture, 30 iterations or 0.01 px, minimal eigenvalue 1e-4.
class RecursiveTracker {
 public:
  /// `window`: odd side of the window in working pixels.
  void set_window(int window) { window_ = window; }

  /// Tracks `points` (working pixels) from the kept frame into `luma`. found[i] is 0 if LK fails. Finds nothing without
  /// a kept frame, or with one of another size. A kept frame serves once: unless keep() follows with this `luma`, the
  /// next call finds nothing. Throws cv::Exception or std::bad_alloc, with `points` unchanged.
  void track(const cv::Mat &luma, std::vector<cv::Point2f> &points, std::vector<unsigned char> &found);
  /// Keeps `luma` (copied into a pyramid) as the frame to track from. Free right after track() with it.
  void keep(const cv::Mat &luma);
  /// Call instead of keep() if there are no points: it builds no pyramid.
  void skip();

 private:
  void build(const cv::Mat &luma);

  int window_ = 21;
  std::vector<cv::Mat> kept_, current_;
  bool kept_valid_ = false, current_valid_ = false;
};

}  // namespace csd
