// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <opencv2/core.hpp>

#include "image/colour_space.h"
#include "image/frame_view.h"

namespace csd {

/// The picture as the tracker works on it: at most 576 lines, 8 bit, isotropic.
///
/// Luma is the Y plane itself where that is 8 bit, contiguous in x and not larger than the working size; else it is
/// gathered and scaled once in load(). Colour is converted only where gather() asks for it. Not thread safe to load();
/// all const functions may run in several threads at once.
class WorkFrame {
 public:
  static constexpr int max_lines = 576;

  /// Takes the next frame. The pixels of `view` must stay valid until the last use of this object, or the next load().
  void load(const FrameView &view);

  const cv::Mat &luma() const { return luma_; }  ///< CV_8UC1, working size
  cv::Size size() const { return luma_.size(); }
  cv::Size picture_size() const { return {view_.width, view_.height}; }

  double scale() const { return scale_x_; }  ///< picture pixels per working pixel
  /// Between picture and working coordinates; pixel centres at integers in both.
  cv::Point2d to_work(cv::Point2d picture) const;
  cv::Point2d to_picture(cv::Point2d work) const;

  /// Colour of the rectangle `r` of the working image (it may reach over the edge: the border is replicated).
  /// `out` becomes CV_8UC3, B G R, full range. A gray picture has R=G=B=Y.
  void gather_bgr(const cv::Rect &r, cv::Mat &out) const;
  /// The same, in one colour space. `out` becomes CV_8UC1.
  void gather(const cv::Rect &r, const ColourSpace &space, cv::Mat &out) const;

 private:
  FrameView view_;
  cv::Mat luma_;
  cv::Mat gathered_, scaled_;
  double scale_x_ = 1, scale_y_ = 1;  ///< view columns and rows per working pixel
};

/// Odd side, in working pixels, of the square patch for a working image of `lines`: 21 from 480 lines on, scaled below,
/// at least 9 (tracking.md A1: one parameter for every resolution).
int default_patch_size(int lines);

}  // namespace csd
