// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <opencv2/core.hpp>

#include <cstdint>
#include <vector>

#include "image/colour_rows.h"
#include "image/colour_space.h"
#include "image/frame_view.h"

namespace csd {

/// The picture as the tracker works on it: at most 576 lines, 8 bit, isotropic.
///
/// One working pixel covers scale() × scale() picture pixels. A field has half the picture's lines, so its working
/// image is half as wide as the picture too. Luma is the Y plane itself where that is 8 bit, contiguous in x and not
/// larger than the working size; else it is gathered and scaled once in load(). Y is as coded (16…235 unless full
/// range); RGB gives Y' = kr·R + kg·G + kb·B in full range. Colour is converted only where gather() asks for it. Not
/// thread safe to load(); all const functions may run in several threads at once.
class WorkFrame {
 public:
  static constexpr int max_lines = 576;

  WorkFrame() = default;
  WorkFrame(WorkFrame &&) = default;
  WorkFrame &operator=(WorkFrame &&) = default;
  // A copy would share its buffers with the original.
  WorkFrame(const WorkFrame &) = delete;
  WorkFrame &operator=(const WorkFrame &) = delete;

  /// Takes the next frame. The pixels of `view` must stay valid until the last use of this object, or the next load().
  /// Throws std::invalid_argument if the view has no pixels.
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
  ///
  /// Where chroma is coarser than the working image, each pixel takes the sample that covers it (chroma siting of a
  /// fraction of a pixel is ignored); where it is finer, the mean of those that its footprint covers.
  void gather_bgr(const cv::Rect &r, cv::Mat &out) const;
  /// The same, in one colour space. `out` becomes CV_8UC1.
  void gather(const cv::Rect &r, const ColourSpace &space, cv::Mat &out) const;

 private:
  /// Samples of a component along one axis that a working pixel covers: [begin, end), never empty.
  struct Footprint {
    int begin = 0, end = 1;
  };

  void load_luma(cv::Size size);
  void load_rgb(cv::Size size);
  static void find_footprints(int samples, int pixels, std::vector<Footprint> &out);
  void read_row(int component, int y, int x, int n, std::uint8_t *out) const;
  void read_row_inside(int component, int y, int x, int n, std::uint8_t *out) const;
  template <class Store>
  void gather_rows(const cv::Rect &r, Store store) const;

  FrameView view_;
  cv::Mat luma_;
  cv::Mat gathered_, scaled_, rgb_scaled_;
  double scale_x_ = 1, scale_y_ = 1;       ///< view columns and rows per working pixel
  FrameView source_;                       ///< where R, G, B or U, V are read: the view, or rgb_scaled_
  bool direct_ = true;                     ///< the source has the working size
  std::vector<Footprint> columns_, rows_;  ///< of the chroma samples, where not direct
  YuvCoefficients yuv_;
};

/// Odd side, in working pixels, of the square patch for a working image of `lines`: 21 from 480 lines on, scaled below,
/// at least 9 (tracking.md A1: one parameter for every resolution).
int default_patch_size(int lines);

}  // namespace csd
