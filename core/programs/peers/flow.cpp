// SPDX-License-Identifier: LGPL-2.1-or-later
#include <opencv2/imgproc.hpp>
#include <opencv2/video/tracking.hpp>
#include <utility>

#include "programs/peers/peer.h"

namespace csd::peers {

namespace {

constexpr double window_side = 21;
constexpr int levels = 3;
constexpr double furthest_return = 1;   // pixels, forward and backward
constexpr double min_similarity = 0.8;  // ZNCC with the first frame's patch

using Pyramid = std::vector<cv::Mat>;
using Points = std::vector<cv::Point2f>;
using Found = std::vector<unsigned char>;

cv::Mat luma(const cv::Mat &bgr) {
  cv::Mat gray;
  cv::cvtColor(bgr, gray, cv::COLOR_BGR2GRAY);
  return gray;
}

/// OpenCV's Lucas–Kanade with the settings of the baseline lk.
class Flow {
 public:
  explicit Flow(int window) : window_(window, window) {}
  Pyramid pyramid(const cv::Mat &gray) const {
    Pyramid out;
    cv::buildOpticalFlowPyramid(gray, out, window_, levels);
    return out;
  }
  /// Tracks points from one picture to another; `guess`, if not empty, has approximate positions.
  Points track(const Pyramid &from, const Pyramid &to, const Points &points, Found &found, Points guess = {}) const {
    std::vector<float> error;
    const int flags = guess.empty() ? 0 : cv::OPTFLOW_USE_INITIAL_FLOW;
    if (!points.empty())
      cv::calcOpticalFlowPyrLK(from, to, points, guess, found, error, window_, levels,
                               {cv::TermCriteria::COUNT | cv::TermCriteria::EPS, 30, 0.01}, flags, 1e-4);
    return guess;
  }

 private:
  cv::Size window_;
};

bool inside(cv::Point2f p, cv::Size size) {
  return p.x >= -0.5f && p.y >= -0.5f && p.x < static_cast<float>(size.width) - 0.5f &&
         p.y < static_cast<float>(size.height) - 0.5f;  // false for NaN
}

Points floats(const std::vector<cv::Point2d> &points) {
  return {points.begin(), points.end()};
}

/// Tracks from frame to frame; drops a point for good if tracking it back doesn't return to the start.
class CheckedFlow final : public Peer {
  void start(const programs::Picture &picture, const std::vector<cv::Point2d> &points) override {
    const auto &bgr = picture.bgr;
    flow_ = Flow(odd_length(window_side, bgr));
    last_ = flow_.pyramid(luma(bgr));
    points_ = floats(points);
    alive_.assign(points.size(), true);
  }

  std::vector<Report> follow(const programs::Picture &picture) override {
    const auto &bgr = picture.bgr;
    auto now = flow_.pyramid(luma(bgr));
    Found there, back;
    const auto moved = flow_.track(last_, now, points_, there);
    const auto home = flow_.track(now, last_, moved, back);
    const double furthest = furthest_return * picture_scale(bgr);
    std::vector<Report> reports;
    for (std::size_t i = 0; i < points_.size(); ++i) {
      alive_[i] = alive_[i] && there[i] && back[i] && inside(moved[i], bgr.size()) &&
                  cv::norm(home[i] - points_[i]) <= furthest;
      if (alive_[i]) points_[i] = moved[i];
      reports.push_back({points_[i], alive_[i]});
    }
    last_ = std::move(now);
    return reports;
  }

  Flow flow_{0};
  Pyramid last_;
  Points points_;
  std::vector<bool> alive_;
};

/// Tracks from frame to frame for a guess, then aligns the first frame's patch to it; seen if similar enough there.
class AnchoredFlow final : public Peer {
  void start(const programs::Picture &picture, const std::vector<cv::Point2d> &points) override {
    const auto &bgr = picture.bgr;
    side_ = odd_length(window_side, bgr);
    flow_ = Flow(side_);
    const auto gray = luma(bgr);
    first_ = last_ = flow_.pyramid(gray);
    anchors_ = points_ = floats(points);
    for (const auto &p : anchors_) patches_.push_back(patch(gray, p));
  }

  std::vector<Report> follow(const programs::Picture &picture) override {
    const auto &bgr = picture.bgr;
    const auto gray = luma(bgr);
    auto now = flow_.pyramid(gray);
    Found chained, aligned;
    auto guess = flow_.track(last_, now, points_, chained);
    for (std::size_t i = 0; i < points_.size(); ++i)
      if (!chained[i] || !inside(guess[i], bgr.size())) guess[i] = points_[i];
    const auto found = flow_.track(first_, now, anchors_, aligned, guess);
    std::vector<Report> reports;
    for (std::size_t i = 0; i < points_.size(); ++i) {
      const bool seen = aligned[i] && inside(found[i], bgr.size()) &&
                        similarity(patches_[i], patch(gray, found[i])) >= min_similarity;
      points_[i] = seen ? found[i] : guess[i];
      reports.push_back({points_[i], seen});
    }
    last_ = std::move(now);
    return reports;
  }

  cv::Mat patch(const cv::Mat &gray, cv::Point2f at) const {
    cv::Mat out;
    cv::getRectSubPix(gray, {side_, side_}, at, out, CV_32F);
    return out;
  }

  static double similarity(const cv::Mat &a, const cv::Mat &b) {
    cv::Mat zncc;
    cv::matchTemplate(a, b, zncc, cv::TM_CCOEFF_NORMED);
    return zncc.at<float>(0, 0);
  }

  Flow flow_{0};
  int side_ = 0;
  Pyramid first_, last_;
  Points anchors_, points_;
  std::vector<cv::Mat> patches_;
};

}  // namespace

std::unique_ptr<Peer> make_flow_checked() {
  return std::make_unique<CheckedFlow>();
}

std::unique_ptr<Peer> make_flow_anchored() {
  return std::make_unique<AnchoredFlow>();
}

}  // namespace csd::peers
