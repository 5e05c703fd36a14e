// SPDX-License-Identifier: LGPL-2.1-or-later
#include "baselines/sift.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace csd {

namespace {

// Lowe's values.
constexpr int octave_layers = 3;
constexpr double contrast_threshold = 0.04;
constexpr double edge_threshold = 10;
constexpr double sigma = 1.6;

constexpr double ratio = 0.6;      // §3.1
constexpr double near = 3;         // working pixels from the feature to a keypoint that may stand for it
constexpr int smallest_side = 16;  // of a picture that cv::SIFT can build its octaves from

}  // namespace

std::optional<int> nearest_by_ratio(const cv::Mat &descriptor, const cv::Mat &candidates, double ratio) {
  if (candidates.rows < 2) return std::nullopt;
  int best = -1;
  double nearest = std::numeric_limits<double>::infinity(), second = nearest;
  for (int i = 0; i < candidates.rows; ++i) {
    const double distance = cv::norm(descriptor, candidates.row(i), cv::NORM_L2SQR);
    if (distance < nearest) {
      second = nearest;
      nearest = distance;
      best = i;
    } else {
      second = std::min(second, distance);
    }
  }
  if (!(nearest < ratio * ratio * second)) return std::nullopt;
  return best;
}

SiftMatching::SiftMatching(const Settings &)
    : sift_(cv::SIFT::create(0, octave_layers, contrast_threshold, edge_threshold, sigma)) {}

void SiftMatching::detect(const FrameContext &context) {
  if (detected_) return;
  keypoints_.clear();
  descriptors_.release();
  const auto &luma = context.frame.luma();
  if (std::min(luma.cols, luma.rows) >= smallest_side)
    sift_->detectAndCompute(luma, cv::noArray(), keypoints_, descriptors_);
  detected_ = true;
}

void SiftMatching::track(const FrameContext &context, std::vector<Claim> &claims) {
  if (!points_.empty()) detect(context);
  auto point = points_.begin();
  for (auto &claim : claims) {
    while (point != points_.end() && point->id < claim.id) ++point;
    claim.kind = Claim::Kind::lost;
    if (point == points_.end() || point->id != claim.id) continue;
    claim.kind = Claim::Kind::hidden;
    if (point->descriptor.empty()) continue;
    const auto match = nearest_by_ratio(point->descriptor, descriptors_, ratio);
    if (!match) continue;
    // The offset turns and grows with the keypoint.
    const auto &k = keypoints_[static_cast<std::size_t>(*match)];
    const double turn = (k.angle - point->keypoint.angle) * CV_PI / 180, grow = k.size / point->keypoint.size;
    const double c = grow * std::cos(turn), s = grow * std::sin(turn);
    const auto &o = point->offset;
    claim.position = context.frame.to_picture(cv::Point2d(k.pt) + cv::Point2d(c * o.x - s * o.y, s * o.x + c * o.y));
    claim.kind = context.bounds().contains(claim.position) ? Claim::Kind::tracked : Claim::Kind::out;
  }
}

Claim::Kind SiftMatching::begin(FeatureId id, cv::Point2d position, const FrameContext &context) {
  detect(context);
  const auto work = context.frame.to_work(position);
  Point point;
  point.id = id;
  double nearest = near;
  for (std::size_t i = 0; i < keypoints_.size(); ++i) {
    const double distance = cv::norm(cv::Point2d(keypoints_[i].pt) - work);
    // Of one place's several orientations and sizes the strongest was not told apart: the first is as good as any.
    if (distance > nearest || (distance == nearest && !point.descriptor.empty())) continue;
    nearest = distance;
    point.keypoint = keypoints_[i];
    point.descriptor = descriptors_.row(static_cast<int>(i)).clone();
    point.offset = work - cv::Point2d(keypoints_[i].pt);
  }
  const auto at =
      std::upper_bound(points_.begin(), points_.end(), id, [](FeatureId i, const Point &p) { return i < p.id; });
  points_.insert(at, std::move(point));
  return Claim::Kind::tracked;
}

void SiftMatching::end(FeatureId id) {
  std::erase_if(points_, [id](const Point &p) { return p.id == id; });
}

void SiftMatching::finish(const FrameContext &) {
  detected_ = false;
}

void SiftMatching::forget() {
  points_.clear();
}

}  // namespace csd
