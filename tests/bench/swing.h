// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <cmath>
#include <opencv2/core.hpp>
#include <vector>

#include "core/picture.h"
#include "core/track/moving_scene.h"

namespace csd {

/// One swing of a scene of 640×480, BGR, which ends where it begins.
inline std::vector<cv::Mat> swing() {
  constexpr int pictures = 20;
  const MovingScene scene({640, 480});
  std::vector<cv::Mat> all;
  for (int i = 0; i < pictures; ++i) {
    const double phase = 2 * CV_PI * i / pictures;
    all.push_back(scene.render({6 * std::sin(phase), 4 * std::cos(phase)}));
  }
  return all;
}

/// The same as I420.
inline std::vector<test::Packed> packed_swing() {
  std::vector<test::Packed> packed;
  for (const auto &picture : swing()) packed.push_back(test::pack(picture, test::Layout::i420));
  return packed;
}

}  // namespace csd
