// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <opencv2/core.hpp>

#include <cstddef>
#include <mutex>
#include <vector>

#include "base/types.h"
#include "track/settings.h"

namespace csd {

/// Requests of other threads to a tracker, queued until the next frame.
///
/// add(), remove(), remove_nearest() and reset() may be called from any thread and never wait for a frame. The rest
/// belongs to the tracking thread: it calls take() when a frame begins and report() when it ends.
class Requests {
 public:
  /// A feature as the requesting threads know it.
  struct Known {
    FeatureId id;
    cv::Point2d position;  ///< picture pixels
    bool in_picture;
  };
  /// The requests of a frame. The tracker erases those it has handled; after a failed frame the rest remains for the
  /// next one.
  struct Taken {
    bool reset = false;              ///< forget the stream, before the rest
    std::vector<StartPoint> added;   ///< points to enter
    std::vector<FeatureId> removed;  ///< features to end
  };

  /// The settings' points have the first ids. With Settings::points_from_start the first max_points ids are reserved.
  explicit Requests(const Settings &settings);

  /// Returns the id of the new point; no_feature if there are max_points.
  FeatureId add(cv::Point2d position);
  /// False if there is no such feature or it is already removed.
  bool remove(FeatureId id);
  /// Removes the feature nearest to `position` in the last frame's picture that is not yet removed, and returns it;
  /// no_feature if there is none.
  FeatureId remove_nearest(cv::Point2d position);
  /// Also drops earlier requests.
  void reset();

  /// Reserves `count` new ids and returns the first.
  FeatureId take_ids(std::size_t count = 1);
  /// Appends the requests to `taken`. Throws std::bad_alloc, with nothing taken.
  void take(Taken &taken);
  /// Reports the features of this frame.
  void report(std::vector<Known> known);

 private:
  std::mutex mutex_;
  FeatureId next_id_ = 0;
  bool reset_ = false;
  std::vector<StartPoint> added_;
  std::vector<FeatureId> removed_;
  std::vector<Known> known_;  ///< the last frame's, updated by the requests taken in the current frame
};

}  // namespace csd
