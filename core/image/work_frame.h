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

/// The picture that the tracker works on: at most 576 lines unless load() gets another limit, 8 bit, isotropic.
///
/// One working pixel covers scale() × scale() picture pixels. A field has half the picture's lines, so its working
/// image has half the width too. Luma is the Y plane itself if that is 8 bit, contiguous in x and not larger than the
/// working size; otherwise load() gathers and scales it once. Y is as coded (16…235 unless full range); RGB gives Y' =
/// kr·R + kg·G + kb·B in full range. Colour is converted only where gather() needs it. load() is not thread safe; all
/// const functions may run in several threads at once.
class WorkFrame {
 public:
  static constexpr int max_lines = 576;

  WorkFrame() = default;
  WorkFrame(WorkFrame &&) = default;
  WorkFrame &operator=(WorkFrame &&) = default;
  // A copy would share its buffers with the original.
  WorkFrame(const WorkFrame &) = delete;
  WorkFrame &operator=(const WorkFrame &) = delete;

  /// Loads the next frame, at most `most_lines` ≥ 1 lines high. The pixels of `view` must stay valid until the last use
  /// of this object or the next load(). Throws std::invalid_argument if the view has no pixels.
  void load(const FrameView &view, int most_lines = max_lines);

  const FrameView &view() const { return view_; }  ///< as given to load()
  const cv::Mat &luma() const { return luma_; }    ///< CV_8UC1, working size
  cv::Size size() const { return luma_.size(); }
  cv::Size picture_size() const { return {view_.width, view_.height}; }

  double scale() const { return scale_x_; }  ///< picture pixels per working pixel
  /// Convert between picture and working coordinates; pixel centres are at integers in both.
  cv::Point2d to_work(cv::Point2d picture) const;
  cv::Point2d to_picture(cv::Point2d work) const;

  /// Colour of the rectangle `r` of the working image; outside the image the border is replicated. `out` becomes
  /// CV_8UC3, B G R, full range. A gray picture has R=G=B=Y.
  ///
  /// A chroma sample is the colour of all pixels that it stands for (siting within a pixel is ignored); a working pixel
  /// is the mean of what it covers. Scaled colour is computed on first use, in bands, and kept until load().
  void gather_bgr(const cv::Rect &r, cv::Mat &out) const;
  /// The same, in one colour space. `out` becomes CV_8UC1.
  void gather(const cv::Rect &r, const ColourSpace &space, cv::Mat &out) const;
  /// The smallest of B, G and R over the whole working image; `out` becomes CV_8UC1. If the picture is not larger than
  /// the working image, it is exactly gather_bgr()'s. Otherwise the distance of the smallest below luma is the nearest
  /// sample's instead of a mean, at a fifth of the cost; on even colour it is the same within 2.
  void gather_least(cv::Mat &out) const;

 private:
  /// Of colour_: the first thread to need a band computes it. Not std::call_once: where libunwind unwinds, as in
  /// gst-launch-1.0, an exception through glibc's function ends the process (seen on Debian 12).
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
  FrameView source_;                  ///< source of R, G, B or U, V: the view, or colour_
  YuvCoefficients yuv_;
  std::array<int, 6> geometry_{};  ///< geometry of the current axes
  AreaAxis columns_[2], rows_[2];  ///< of luma, R, G and B; of chroma
  mutable cv::Mat colour_[3];      ///< R, G, B or –, U, V at working size; a band is written once, under its lock
  std::unique_ptr<Band[]> bands_;  ///< null if the source is the view
};

/// Odd side, in working pixels, of the square patch for a working image of `lines`: 21 from 480 lines on, proportional
/// below, at least 9 (one parameter for every resolution).
int default_patch_size(int lines);

}  // namespace csd
