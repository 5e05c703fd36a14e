// SPDX-License-Identifier: LGPL-2.1-or-later
#include <cmath>
#include <opencv2/tracking.hpp>
#include <opencv2/tracking/tracking_legacy.hpp>
#include <utility>

#include "programs/peers/peer.h"

namespace csd::peers {

namespace {

constexpr double box_side = 29;  // as in STIR's baseline

cv::Point2d centre(const cv::Rect2d &box) {
  return {box.x + (box.width - 1) / 2, box.y + (box.height - 1) / 2};
}

/// One tracker per point. After a failure it is called again in the next frame: some recover.
class Boxes final : public Peer {
 public:
  using Make = cv::Ptr<cv::legacy::Tracker> (*)();
  explicit Boxes(Make make) : make_(make) {}

  void start(const programs::Picture &picture, const std::vector<cv::Point2d> &points) override {
    const auto &bgr = picture.bgr;
    const int side = odd_length(box_side, bgr), half = side / 2;
    for (const auto &p : points) {
      Box b;
      b.box = cv::Rect2d(std::round(p.x) - half, std::round(p.y) - half, side, side);
      b.offset = p - centre(b.box);
      b.last = p;
      b.tracker = make_();
      if (!attempt([&] { return b.tracker->init(bgr, b.box); })) b.tracker.release();
      boxes_.push_back(std::move(b));
    }
  }

  std::vector<Report> follow(const programs::Picture &picture) override {
    const auto &bgr = picture.bgr;
    std::vector<Report> reports;
    for (auto &b : boxes_) {
      const bool seen = b.tracker && attempt([&] { return b.tracker->update(bgr, b.box); });
      const auto at = centre(b.box) + b.offset;
      if (seen && std::isfinite(at.x) && std::isfinite(at.y)) b.last = at;
      reports.push_back({b.last, seen && b.last == at});
    }
    return reports;
  }

 private:
  struct Box {
    cv::Ptr<cv::legacy::Tracker> tracker;  ///< null: initialisation failed
    cv::Rect2d box;
    cv::Point2d offset;  ///< from the box's centre to the point
    cv::Point2d last;    ///< last reported position
  };

  // Some throw at the picture's edge.
  template <class Action>
  static bool attempt(Action action) {
    try {
      return action();
    } catch (const cv::Exception &error) {
      if (error.code == cv::Error::StsNoMem) throw;
      return false;
    }
  }

  Make make_;
  std::vector<Box> boxes_;
};

}  // namespace

std::unique_ptr<Peer> make_csrt() {
  return std::make_unique<Boxes>([]() -> cv::Ptr<cv::legacy::Tracker> { return cv::legacy::TrackerCSRT::create(); });
}

std::unique_ptr<Peer> make_kcf() {
  return std::make_unique<Boxes>([]() -> cv::Ptr<cv::legacy::Tracker> { return cv::legacy::TrackerKCF::create(); });
}

std::unique_ptr<Peer> make_median_flow() {
  return std::make_unique<Boxes>(
      []() -> cv::Ptr<cv::legacy::Tracker> { return cv::legacy::TrackerMedianFlow::create(); });
}

}  // namespace csd::peers
