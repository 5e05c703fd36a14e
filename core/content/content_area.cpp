// SPDX-License-Identifier: LGPL-2.1-or-later
#include "content/content_area.h"

#include <opencv2/imgproc.hpp>

#include <cmath>

namespace csd {
namespace {

constexpr double ns_per_second = 1e9;
constexpr std::int64_t border_period = 200'000'000;    // ns: it hardly changes; an update takes up to 4 ms at 576 lines
constexpr std::int64_t graphics_period = 150'000'000;  // ns: six updates a second separate moving from fixed

/// Whether the next update is due; a stream that jumped back starts a new period. `elapsed` is in seconds.
bool due(bool started, std::int64_t now, std::int64_t period, std::int64_t &last, double &elapsed) {
  const std::int64_t since = now - last;
  if (started && since >= 0 && since < period) return false;
  elapsed = started && since > 0 ? static_cast<double>(since) / ns_per_second : 0;
  last = now;
  return true;
}

}  // namespace

void ContentAreaFinder::reset() {
  *this = ContentAreaFinder();
}

void ContentAreaFinder::update(const cv::Mat &luma, std::int64_t time, int patch) {
  CV_Assert(luma.type() == CV_8UC1 && !luma.empty() && patch > 0);
  if (luma.size() != forbidden_.size()) reset();
  double elapsed = 0;
  bool stale = !started_ || patch != patch_;
  // Until the picture is lit, each frame may be the first that shows the border.
  if (due(started_, time, border_.lit() ? border_period : 0, last_border_, elapsed))
    stale |= border_.update(luma, elapsed);
  if (due(started_, time, graphics_period, last_graphics_, elapsed)) stale |= graphics_.update(luma, elapsed);
  started_ = true;
  patch_ = patch;
  changed_ = stale;
  if (stale) grow(luma.size(), patch);
}

void ContentAreaFinder::grow(cv::Size size, int patch) {
  cv::Mat all;
  cv::resize(border_.mask(), all, graphics_.mask().size(), 0, 0, cv::INTER_NEAREST);
  all |= graphics_.mask();
  // Patches are squares, so the kernel is one too: half a patch on each side, plus a pixel of the copy for the blur of
  // downscaling.
  const double shrink = static_cast<double>(size.height) / all.rows;
  const int half = patch / 2, radius = static_cast<int>(std::ceil(half / shrink)) + 1;
  cv::Mat grown;
  cv::dilate(all, grown, cv::getStructuringElement(cv::MORPH_RECT, {2 * radius + 1, 2 * radius + 1}));
  cv::resize(grown, forbidden_, size, 0, 0, cv::INTER_NEAREST);
}

bool ContentAreaFinder::contains(cv::Point2d p) const {
  if (!(p.x > -0.5 && p.y > -0.5 && p.x < forbidden_.cols - 0.5 && p.y < forbidden_.rows - 0.5)) return false;
  return forbidden_.at<std::uint8_t>(cvRound(p.y), cvRound(p.x)) != 0;
}

}  // namespace csd
