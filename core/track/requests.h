// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <opencv2/core.hpp>

#include <cstddef>
#include <mutex>
#include <vector>

#include "track/types.h"

namespace csd {

/// What other threads ask of a tracker, until a frame takes it.
///
/// add(), remove(), remove_nearest() and reset() may be called from any thread and never wait for a frame. The rest is
/// for the thread that tracks: it calls take() as a frame begins and report() as it ends.
class Requests {
 public:
  /// A feature as those who ask know it.
  struct Known {
    FeatureId id;
    cv::Point2d position;  ///< picture pixels
    bool in_picture;
  };
  /// What a frame has to do first. The tracker takes out what it has done: the rest is left to the frame after one that
  /// failed.
  struct Taken {
    bool reset = false;              ///< forget the stream, before the rest
    std::vector<StartPoint> added;   ///< points to enter
    std::vector<FeatureId> removed;  ///< features to end
  };

  /// The settings' points have the first ids; with Settings::points_from_start the first max_points are set apart.
  explicit Requests(const Settings &settings);

  /// The id of a new point; no_feature if there are max_points.
  FeatureId add(cv::Point2d position);
  /// False if there is no such feature, or it is removed already.
  bool remove(FeatureId id);
  /// The feature in the last frame's picture that is nearest and not removed already; no_feature if there is none.
  FeatureId remove_nearest(cv::Point2d position);
  /// What was asked before is forgotten too.
  void reset();

  /// The first of `count` new ids.
  FeatureId take_ids(std::size_t count = 1);
  /// Adds to `taken`. Throws std::bad_alloc, and has then taken nothing.
  void take(Taken &taken);
  /// These features there are, with this frame.
  void report(std::vector<Known> known);

 private:
  std::mutex mutex_;
  FeatureId next_id_ = 0;
  bool reset_ = false;
  std::vector<StartPoint> added_;
  std::vector<FeatureId> removed_;
  std::vector<Known> known_;  ///< the last frame's, but for what a frame under way has taken: with it or without
};

}  // namespace csd
