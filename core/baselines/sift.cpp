// SPDX-License-Identifier: LGPL-2.1-or-later
#include "baselines/sift.h"

#include <algorithm>
#include <cmath>

namespace csd {

namespace {

// Lowe's values, except for the contrast: with his, tissue has few keypoints (docs/baselines.md has the measurement).
constexpr int octave_layers = 3;
constexpr double contrast_threshold = 0.01;
constexpr double edge_threshold = 10;
constexpr double sigma = 1.6;

constexpr double ratio = 0.6;      // §3.1
constexpr double near = 5;         // working pixels, greatest distance of a feature's keypoint
constexpr int smallest_side = 16;  // of a picture from which cv::SIFT can build its octaves

}  // namespace

std::vector<int> match_by_ratio(const cv::Mat &descriptors, const cv::Mat &candidates, double ratio) {
  std::vector<int> matches(static_cast<std::size_t>(descriptors.rows), -1);
  if (descriptors.empty() || candidates.rows < 2) return matches;
  std::vector<std::vector<cv::DMatch>> nearest;
  cv::BFMatcher(cv::NORM_L2).knnMatch(descriptors, candidates, nearest, 2);
  for (std::size_t i = 0; i < matches.size(); ++i)
    if (nearest[i][0].distance < ratio * nearest[i][1].distance) matches[i] = nearest[i][0].trainIdx;
  return matches;
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
  detected_ = false;  // also if the last frame ended in an exception
  cv::Mat wanted;
  for (const auto &point : points_)
    if (!point.descriptor.empty()) wanted.push_back(point.descriptor);
  std::vector<int> matches;
  if (!wanted.empty()) {
    detect(context);
    matches = match_by_ratio(wanted, descriptors_, ratio);
  }
  for (auto &claim : claims) claim.kind = Claim::Kind::lost;
  auto match = matches.begin();
  auto claim = claims.begin();
  for (const auto &point : points_) {
    while (claim->id != point.id) ++claim;
    claim->kind = Claim::Kind::hidden;
    if (point.descriptor.empty() || *match++ < 0) continue;
    // The offset rotates and scales with the keypoint.
    const auto &k = keypoints_[static_cast<std::size_t>(match[-1])];
    const double turn = (k.angle - point.keypoint.angle) * CV_PI / 180, grow = k.size / point.keypoint.size;
    const double c = grow * std::cos(turn), s = grow * std::sin(turn);
    const auto &o = point.offset;
    claim->position = context.frame.to_picture(cv::Point2d(k.pt) + cv::Point2d(c * o.x - s * o.y, s * o.x + c * o.y));
    claim->kind = context.bounds().contains(claim->position) ? Claim::Kind::tracked : Claim::Kind::out;
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
    // A place with several dominant orientations has a keypoint for each: any of them will do.
    if (distance >= nearest) continue;
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

void SiftMatching::forget() {
  points_.clear();
}

}  // namespace csd
