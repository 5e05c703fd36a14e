// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <opencv2/core.hpp>

#include <array>
#include <cstdint>

namespace csd {

/// The working image's luma, smoothed, at five resolutions: the input of `csd`'s alignment.
///
/// Level 0 is the luma after a Gaussian of σ = 1 px, because single pixels are too noisy to compare. It is the binomial
/// filter 1 4 6 4 1, whose variance is exactly 1 and whose sums are exact in 16 bit. Its taps .0625 .25 .375 differ
/// from the ideal .0540 .2420 .3989 (.0044 next) by at most .024, its transfer function by at most .051. Level l+1 is
/// every second pixel of level l after the same filter, rounded to nearest: pixel (x, y) of level l is at (2^l·x,
/// 2^l·y) of level 0. Samples are CV_16UC1, 1/256 of a grey level: eight bits would round away the signal of faint
/// tissue, whose gain can be .1. The border is mirrored without the edge pixel, as cv::BORDER_REFLECT_101.
class Pyramid {
 public:
  static constexpr int levels = 5;
  static constexpr int smallest = 16;  ///< pixels, least width and height of a picture

  /// `luma`: CV_8UC1, at least `smallest` pixels wide and high; not kept. Throws std::invalid_argument otherwise.
  void build(const cv::Mat &luma);

  bool empty() const { return levels_[0].empty(); }
  /// 0 ≤ l < levels. A level has (w+1)/2 × (h+1)/2 pixels of the previous one.
  const cv::Mat &level(int l) const { return levels_[static_cast<std::size_t>(l)]; }

 private:
  std::array<cv::Mat, levels> levels_;
};

}  // namespace csd
