// SPDX-License-Identifier: LGPL-2.1-or-later
#include <opencv2/imgproc.hpp>

#include <stdexcept>

#include "cli/peers/peer.h"
#include "track/thread_pool.h"
#include "track/tracker.h"

namespace csd::peers {

namespace {

constexpr double sigma = 1;  // pixels at up to 576 lines, as the working image has

/// csd-2012 as it is, behind a smoothing filter: the paper compares single pixels, and says nothing of noise.
class SmoothedCsd2012 final : public Peer {
 public:
  void start(const cli::Picture &picture, const std::vector<cv::Point2d> &points) override {
    if (points.size() > max_points) throw std::invalid_argument("csd-2012-smoothed: too many points");
    Settings settings;
    settings.algorithm = AlgorithmKind::csd_2012;
    settings.points = points;
    settings.content_area = ContentArea::full;
    settings.learn_synchronously = true;
    tracker_ = std::make_unique<Tracker>(settings, pool_);
    process(picture);
  }

  std::vector<Report> follow(const cli::Picture &picture) override { return process(picture); }

 private:
  std::vector<Report> process(const cli::Picture &picture) {
    cv::GaussianBlur(picture.bgr, smooth_, {}, sigma * picture_scale(picture.bgr));
    FrameView view;
    view.width = smooth_.cols;
    view.height = view.rows = smooth_.rows;
    view.model = ColourModel::rgb;
    // R, G, B in that order, from B, G, R in memory.
    for (std::size_t i = 0; i < view.component.size(); ++i) {
      view.component[i].data = smooth_.data + (2 - i);
      view.component[i].row_stride = static_cast<std::ptrdiff_t>(smooth_.step);
      view.component[i].pixel_stride = 3;
    }
    std::vector<Report> reports;
    for (const auto &f : tracker_->process(view, picture.running_time, picture.duration).features)
      reports.push_back({{f.x, f.y}, claims_position(f.state)});
    return reports;
  }

  ThreadPool pool_{1};
  std::unique_ptr<Tracker> tracker_;  // after the pool, which must outlive it
  cv::Mat smooth_;
};

}  // namespace

std::unique_ptr<Peer> make_smoothed_csd2012() {
  return std::make_unique<SmoothedCsd2012>();
}

}  // namespace csd::peers
