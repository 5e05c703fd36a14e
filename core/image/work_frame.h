// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <opencv2/core.hpp>

#include <array>
#include <atomic>
#include <cstdint>
#include <memory>
#include <mutex>

#include "image/area_scaler.h"
#include "image/colour_rows.h"
#include "image/colour_space.h"
#include "image/frame_view.h"

namespace csd {

/// The picture as the tracker works on it: 576 lines at most, if load() is not told otherwise, 8 bit, isotropic.
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

  /// Takes the next frame, at most `most` ≥ 1 lines high. The pixels of `view` must stay valid until the last use of
  /// this object, or the next load(). Throws std::invalid_argument if the view has no pixels.
  void load(const FrameView &view, int most = max_lines);

  const FrameView &view() const { return view_; }  ///< what load() was given
  const cv::Mat &luma() const { return luma_; }    ///< CV_8UC1, working size
  cv::Size size() const { return luma_.size(); }
  cv::Size picture_size() const { return {view_.width, view_.height}; }

  double scale() const { return scale_x_; }  ///< picture pixels per working pixel
  /// Between picture and working coordinates; pixel centres at integers in both.
  cv::Point2d to_work(cv::Point2d picture) const;
  cv::Point2d to_picture(cv::Point2d work) const;

  /// Colour of the rectangle `r` of the working image (it may reach over the edge: the border is replicated).
  /// `out` becomes CV_8UC3, B G R, full range. A gray picture has R=G=B=Y.
  ///
  /// A chroma sample is the colour of all pixels that it stands for (siting of a fraction of a pixel is ignored); a
  /// working pixel is the mean of what it covers. Scaled colour is made on first use, in bands, and kept until load().
  void gather_bgr(const cv::Rect &r, cv::Mat &out) const;
  /// The same, in one colour space. `out` becomes CV_8UC1.
  void gather(const cv::Rect &r, const ColourSpace &space, cv::Mat &out) const;
  /// The least of B, G and R over the whole working image, `out` becomes CV_8UC1: what gather_bgr() gives, where the
  /// picture isn't larger than the working image. Where it is, how far the least lies below luma is the nearest
  /// sample's and not a mean, which costs a fifth: the same on even colour within 2.
  void gather_least(cv::Mat &out) const;

 private:
  /// Of colour_: who finds a band unmade makes it. Not std::call_once: where libunwind unwinds, as in gst-launch-1.0,
  /// an exception that passes glibc's function is the end of the process (seen, Debian 12).
  struct Band {
    std::mutex making;
    std::atomic<bool> made = false;
  };

  void find_axes(cv::Size size);
  void prepare_colour(cv::Size size);
  void scale_colour(int begin, int end) const;
  void read_row(int component, int y, int x, int n, std::uint8_t *out) const;
  void read_row_inside(int component, int y, int x, int n, std::uint8_t *out) const;
  template <class Store>
  void gather_rows(const cv::Rect &r, Store store) const;

  FrameView view_;
  cv::Mat luma_, own_luma_;
  double scale_x_ = 1, scale_y_ = 1;  ///< view columns and rows per working pixel
  FrameView source_;                  ///< where R, G, B or U, V are read: the view, or colour_
  YuvCoefficients yuv_;
  std::array<int, 6> geometry_{};  ///< what the axes were made for
  AreaAxis columns_[2], rows_[2];  ///< of luma, R, G and B; of chroma
  mutable cv::Mat colour_[3];      ///< R, G, B or –, U, V at working size: a band is written once, under its lock
  std::unique_ptr<Band[]> bands_;  ///< null where the source is the view
};

/// Odd side, in working pixels, of the square patch for a working image of `lines`: 21 from 480 lines on, scaled below,
/// at least 9 (one parameter for every resolution).
int default_patch_size(int lines);

}  // namespace csd
