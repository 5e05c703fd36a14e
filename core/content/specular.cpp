// SPDX-License-Identifier: LGPL-2.1-or-later
#include "content/specular.h"

#include <opencv2/imgproc.hpp>

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "image/work_frame.h"

namespace csd {
namespace {

/// V = max/255 and S = (max − min)/max, compared in integers: max ≥ min_value, (max − min)·2^16 ≤ max · part.
struct Thresholds {
  int min_value, part;
  explicit Thresholds(const SpecularOptions &o)
      : min_value(static_cast<int>(std::ceil(o.value * 255))),
        part(static_cast<int>(std::lround(o.saturation * 65536))) {}
};

void threshold(const cv::Mat &bgr, const Thresholds &t, cv::Mat &out) {
  out.create(bgr.size(), CV_8UC1);
  for (int y = 0; y < bgr.rows; ++y) {
    const std::uint8_t *p = bgr.ptr(y);
    std::uint8_t *to = out.ptr(y);
    for (int x = 0; x < bgr.cols; ++x, p += 3) {
      const int high = std::max({p[0], p[1], p[2]}), low = std::min({p[0], p[1], p[2]});
      // Branchless: highlights are scattered.
      const int marked =
          static_cast<int>(high >= t.min_value) & static_cast<int>((high - low) * 65536 <= high * t.part);
      to[x] = static_cast<std::uint8_t>(-marked);
    }
  }
}

}  // namespace

int specular_margin(int lines, const SpecularOptions &options) {
  return std::max(0, static_cast<int>(std::lround(options.margin * lines / WorkFrame::max_lines)));
}

void specular_mask(const WorkFrame &frame, const cv::Rect &r, cv::Mat &mask, const SpecularOptions &options) {
  const cv::Rect image({}, frame.size());
  const int margin = specular_margin(image.height, options);
  mask.create(r.size(), CV_8UC1);
  mask.setTo(0);
  const cv::Rect inside = r & image;
  if (inside.empty()) return;
  const cv::Rect seen = (r + cv::Size(2 * margin, 2 * margin) - cv::Point(margin, margin)) & image;

  cv::Mat bgr, bright;
  frame.gather_bgr(seen, bgr);
  threshold(bgr, Thresholds(options), bright);
  const int side = 2 * margin + 1;
  // OpenCV's default border for dilate adds nothing.
  cv::dilate(bright, bright, cv::getStructuringElement(cv::MORPH_ELLIPSE, {side, side}));
  bright(inside - seen.tl()).copyTo(mask(inside - r.tl()));
}

}  // namespace csd
