// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <cstdint>
#include <opencv2/imgproc.hpp>

#include "image/frame_view.h"

namespace csd {

/// A coloured texture of blobs, seen by a camera through a window. Each point's place is known exactly.
class MovingScene {
 public:
  explicit MovingScene(cv::Size size = {320, 240}, std::uint64_t seed = 5) : size_(size) {
    cv::Mat noise(size.height + 2 * margin, size.width + 2 * margin, CV_32FC3), coarse;
    cv::RNG rng(seed);
    rng.fill(noise, cv::RNG::NORMAL, 0, 1);
    cv::GaussianBlur(noise, texture_, {0, 0}, 2.5);
    cv::GaussianBlur(noise, coarse, {0, 0}, 8);
    texture_ = texture_ * 150 + coarse * 300 + cv::Scalar(90, 100, 150);
  }

  /// The scene with its texture moved by `shift` (pixels, |x|,|y| < 40): B G R.
  cv::Mat render(cv::Point2d shift) const {
    cv::Mat moved, out;
    const cv::Matx23d m(1, 0, shift.x - margin, 0, 1, shift.y - margin);
    cv::warpAffine(texture_, moved, m, size_, cv::INTER_LINEAR, cv::BORDER_REFLECT_101);
    moved.convertTo(out, CV_8UC3);
    return out;
  }

  static FrameView view(const cv::Mat &bgr) {
    FrameView v;
    v.width = bgr.cols;
    v.height = v.rows = bgr.rows;
    v.model = ColourModel::rgb;
    const auto stride = static_cast<std::ptrdiff_t>(bgr.step);
    for (std::size_t i = 0; i < 3; ++i) v.component[i] = {bgr.data + 2 - i, stride, 3, 1, 0, 0, 0};
    return v;
  }

  static FrameView gray_view(const cv::Mat &gray) {
    FrameView v;
    v.width = gray.cols;
    v.height = v.rows = gray.rows;
    v.component[0] = {gray.data, static_cast<std::ptrdiff_t>(gray.step), 1, 1, 0, 0, 0};
    return v;
  }

 private:
  static constexpr int margin = 40;
  cv::Size size_;
  cv::Mat texture_;
};

}  // namespace csd
