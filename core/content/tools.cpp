// SPDX-License-Identifier: LGPL-2.1-or-later
#include "content/tools.h"

#include <opencv2/imgproc.hpp>

#include <algorithm>
#include <array>
#include <cstdint>

#include "image/work_frame.h"

namespace csd {
namespace {

// Chosen on six clips. Saturation of tools .05 to .14, of the palest tissue (gallbladder, peritoneum) .18 to .25.
// Through smoke, tools .11 to .15, and half of the picture below .23.
constexpr int max_saturation = 36;  // of 255
constexpr int part_of_median = 60;  // %
constexpr int min_light = 32;
constexpr int small_lines = 120;  // of the downscaled copy

}  // namespace

void find_tools(const WorkFrame &frame, cv::Mat &mask) {
  WorkFrame copy;
  copy.load(frame.view(), small_lines);
  cv::Mat small;
  copy.gather_bgr({{}, copy.size()}, small);
  cv::blur(small, small, {3, 3});

  std::array<int, 256> histogram{};
  int lit = 0;
  cv::Mat1b saturation(small.size(), std::uint8_t{255});
  for (int y = 0; y < small.rows; ++y)
    for (int x = 0; x < small.cols; ++x) {
      const auto &p = small.at<cv::Vec3b>(y, x);
      const int high = std::max({p[0], p[1], p[2]}), low = std::min({p[0], p[1], p[2]});
      if (high < min_light) continue;
      saturation(y, x) = static_cast<std::uint8_t>(255 * (high - low) / high);
      ++histogram[saturation(y, x)];
      ++lit;
    }
  int median = 0;
  for (int below = histogram[0]; 2 * below < lit; below += histogram[static_cast<std::size_t>(median)]) ++median;

  const int limit = std::min(max_saturation, part_of_median * median / 100);
  cv::Mat grey = saturation < limit;
  cv::dilate(grey, grey, cv::getStructuringElement(cv::MORPH_RECT, {7, 7}));
  cv::resize(grey, mask, frame.size(), 0, 0, cv::INTER_NEAREST);
}

}  // namespace csd
