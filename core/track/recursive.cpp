// SPDX-License-Identifier: LGPL-2.1-or-later
#include "track/recursive.h"

#include <opencv2/video/tracking.hpp>

namespace csd {

namespace {
constexpr int levels = 3;  // above the picture
constexpr int iterations = 30;
constexpr double epsilon = 0.01;         // working pixels
constexpr double min_eigenvalue = 1e-4;  // mean over the window, OpenCV's scale
}  // namespace

void RecursiveTracker::build(const cv::Mat &luma) {
  // Never uses the input in place: its buffer is gone by the next frame.
  current_valid_ = false;
  try {
    cv::buildOpticalFlowPyramid(luma, current_, {window_, window_}, levels, true, cv::BORDER_REFLECT_101,
                                cv::BORDER_CONSTANT, false);
  } catch (...) {
    current_.clear();  // otherwise OpenCV 4.6 would read invalid memory next time
    throw;
  }
  current_valid_ = true;
}

void RecursiveTracker::track(const cv::Mat &luma, std::vector<cv::Point2f> &points, std::vector<unsigned char> &found) {
  found.assign(points.size(), 0);
  current_valid_ = false;
  if (!points.empty()) build(luma);
  if (current_valid_ && kept_valid_ && kept_[0].size() == current_[0].size()) {
    std::vector<cv::Point2f> next;
    std::vector<float> error;
    cv::calcOpticalFlowPyrLK(kept_, current_, points, next, found, error, {window_, window_}, levels,
                             {cv::TermCriteria::COUNT | cv::TermCriteria::EPS, iterations, epsilon}, 0, min_eigenvalue);
    for (std::size_t i = 0; i < points.size(); ++i)
      if (!std::isfinite(next[i].x) || !std::isfinite(next[i].y)) found[i] = 0, next[i] = points[i];
    points.swap(next);
  }
  kept_valid_ = false;
}

void RecursiveTracker::keep(const cv::Mat &luma) {
  if (!current_valid_) build(luma);
  kept_.swap(current_);
  kept_valid_ = true;
  current_valid_ = false;
}

void RecursiveTracker::skip() {
  kept_.clear();
  kept_valid_ = current_valid_ = false;
}

}  // namespace csd
