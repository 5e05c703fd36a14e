// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <opencv2/core.hpp>

#include <cstddef>
#include <cstdint>

#include "image/frame_view.h"

namespace csd::bench {

/// A raw I420 picture of even sides, with the matrix that cv::cvtColor uses.
inline FrameView view_of(const std::uint8_t *pixels, cv::Size size) {
  FrameView v;
  v.width = size.width;
  v.height = v.rows = size.height;
  v.model = ColourModel::yuv;
  v.kr = 0.299;
  v.kb = 0.114;
  const std::ptrdiff_t width = size.width, luma = width * size.height;
  v.component[0] = {pixels, width, 1, 1, 0, 0, 0};
  v.component[1] = {pixels + luma, width / 2, 1, 1, 0, 1, 1};
  v.component[2] = {pixels + luma + luma / 4, width / 2, 1, 1, 0, 1, 1};
  return v;
}

}  // namespace csd::bench
