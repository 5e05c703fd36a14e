// SPDX-License-Identifier: LGPL-2.1-or-later
#include "content/dark_border.h"

#include <opencv2/imgproc.hpp>

#include <algorithm>
#include <cmath>

namespace csd {
namespace {

constexpr int max_lines = 144;  // of the small picture

// Video black is 16, and coding noise raises it to about 25. Chosen by eye: anything darker has no texture.
constexpr std::uint8_t dark_below = 28;

constexpr double memory = 1.0;        // s, of dark_share_
constexpr float becomes_dark = 0.9F;  // share, reached after 2.3 s of dark
constexpr float stays_dark = 0.75F;   // share, lost after 0.3 s of light
constexpr double wholly_dark = 0.98;  // share of the picture
constexpr double field_share = 0.25;  // of the largest lit region; smaller regions are text in the border
constexpr int crevice = 5;            // px of the small picture: a thinner dark line is anatomy, except along the edge

/// 255 in the large regions of `lit`, 0 elsewhere.
cv::Mat large_regions(const cv::Mat &lit) {
  cv::Mat labels, stats, centroids;
  const int n = cv::connectedComponentsWithStats(lit, labels, stats, centroids, 4, CV_32S);
  int largest = 0;
  for (int i = 1; i < n; ++i) largest = std::max(largest, stats.at<int>(i, cv::CC_STAT_AREA));
  cv::Mat large = cv::Mat::zeros(lit.size(), CV_8UC1);
  for (int i = 1; i < n; ++i) {
    if (stats.at<int>(i, cv::CC_STAT_AREA) >= field_share * largest) large.setTo(255, labels == i);
  }
  return large;
}

}  // namespace

void DarkBorder::reset() {
  *this = DarkBorder();
}

bool DarkBorder::update(const cv::Mat &luma, double dt) {
  CV_Assert(luma.type() == CV_8UC1 && !luma.empty());
  if (luma.size() != luma_size_) {
    reset();
    luma_size_ = luma.size();
    const int shrink = std::max(1, (luma.rows + max_lines - 1) / max_lines);
    mask_.create(std::max(1, luma.rows / shrink), std::max(1, luma.cols / shrink), CV_8UC1);
    mask_.setTo(0);
  }
  cv::resize(luma, small_, mask_.size(), 0, 0, cv::INTER_AREA);
  const cv::Mat now = small_ < dark_below;

  if (cv::countNonZero(now) >= wholly_dark * static_cast<double>(now.total())) {
    if (lit_ || (!dark_.empty() && cv::countNonZero(dark_) == static_cast<int>(dark_.total()))) return false;
    dark_ = cv::Mat(now.size(), CV_8UC1, cv::Scalar(255));
    mask_.setTo(255);
    return true;
  }
  if (!lit_) {
    lit_ = true;
    now.convertTo(dark_share_, CV_32F, 1.0 / 255);
    dark_ = now;
    decide();
    return true;
  }
  const auto keep = static_cast<float>(std::exp(-std::clamp(dt, 0.0, memory) / memory));
  bool changed = false;
  for (int y = 0; y < now.rows; ++y) {
    const std::uint8_t *is = now.ptr<std::uint8_t>(y);
    float *share = dark_share_.ptr<float>(y);
    std::uint8_t *held = dark_.ptr<std::uint8_t>(y);
    std::uint8_t differs = 0;
    for (int x = 0; x < now.cols; ++x) {
      share[x] = keep * share[x] + (1 - keep) * (is[x] != 0 ? 1.0F : 0.0F);
      const float limit = held[x] != 0 ? stays_dark : becomes_dark;
      const std::uint8_t next = share[x] > limit ? 255 : 0;
      differs |= static_cast<std::uint8_t>(next ^ held[x]);
      held[x] = next;
    }
    changed |= differs != 0;
  }
  if (!changed) return false;
  const cv::Mat before = mask_.clone();
  decide();
  return cv::norm(before, mask_, cv::NORM_INF) > 0;
}

void DarkBorder::decide() {
  // Adds a dark rim, because the outside is dark: the opening then keeps a border of a single column only along the
  // edge, and everything joined to the edge is one region.
  constexpr int rim = crevice;
  cv::Mat dark;
  cv::copyMakeBorder(dark_, dark, rim, rim, rim, rim, cv::BORDER_CONSTANT, cv::Scalar(255));
  cv::morphologyEx(dark, dark, cv::MORPH_OPEN, cv::getStructuringElement(cv::MORPH_ELLIPSE, {crevice, crevice}));
  cv::floodFill(dark, {0, 0}, cv::Scalar(128));
  const cv::Mat border = large_regions(dark != 128)(cv::Rect(rim, rim, dark_.cols, dark_.rows)) == 0;
  // A pixel that is partly border may be bright enough to pass as lit.
  cv::dilate(border, mask_, cv::getStructuringElement(cv::MORPH_RECT, {3, 3}));
}

}  // namespace csd
