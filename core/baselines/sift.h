// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <opencv2/features2d.hpp>

#include <vector>

#include "track/algorithm.h"

namespace csd {

/// The ratio test of Lowe (2004). For each row of `descriptors` returns the nearest row of `candidates` (both CV_32F,
/// of equal width) by Euclidean distance, if that is less than `ratio` times the distance of the second nearest; else
/// −1. With fewer than two candidates all are −1.
std::vector<int> match_by_ratio(const cv::Mat &descriptors, const cv::Mat &candidates, double ratio);

/// The baseline SIFT of §3: tracking by detection. Matches each frame's DoG keypoints with the descriptor of the
/// feature's first frame, nearest neighbour with ratio 0.6, in the whole picture, without temporal information
/// (docs/baselines.md). Without a match the feature is hidden.
class SiftMatching final : public Algorithm {
 public:
  explicit SiftMatching(const Settings &settings);

  void track(const FrameContext &context, std::vector<Claim> &claims) override;
  Claim::Kind begin(FeatureId id, cv::Point2d position, const FrameContext &context) override;
  void end(FeatureId id) override;
  void finish(const FrameContext &) override {}
  void forget() override;
  void add_to(Stats &) const override {}

 private:
  struct Point {
    FeatureId id;
    cv::KeyPoint keypoint;  ///< of the first frame, working pixels
    cv::Mat descriptor;     ///< its descriptor, one row; empty: there was no keypoint
    cv::Point2d offset;     ///< from the keypoint to the feature, in the first frame
  };
  void detect(const FrameContext &context);

  cv::Ptr<cv::SIFT> sift_;
  std::vector<Point> points_;  ///< by ascending id
  bool detected_ = false;      ///< keypoints_ are this frame's
  std::vector<cv::KeyPoint> keypoints_;
  cv::Mat descriptors_;
};

}  // namespace csd
