// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <memory>

#include "base/types.h"
#include "image/frame_view.h"
#include "track/settings.h"

namespace csd {

class Algorithm;

/// Tracks many features through a stream of frames: detects them, lets the algorithm track them, and keeps their
/// states.
///
/// process() belongs to one thread. add_point(), remove_point(), remove_nearest(), reset() and stats() may be called
/// from any thread and never wait for a frame. Trackers share nothing.
class Tracker {
 public:
  /// `algorithm`: from make_algorithm(settings), or a test's or an experiment's.
  Tracker(const Settings &settings, std::unique_ptr<Algorithm> algorithm);
  ~Tracker();

  /// Tracks all features into the next frame. `pts` and `duration` in ns, no_time if unknown (25 frames a second are
  /// then assumed). `discont`: the frame does not follow the last one; a `pts` more than half a second off means the
  /// same. A change of the picture's size forgets the stream. The result is valid until the next call. Throws
  /// cv::Exception and std::bad_alloc, also those of a learner; the tracker remains usable.
  const Tracks &process(const FrameView &view, std::int64_t pts, std::int64_t duration = no_time, bool discont = false);

  /// Processes a frame without a picture: every feature that is not out or ended becomes lost. Right after process() or
  /// process_blind() threw, it processes the same frame, and time does not advance.
  const Tracks &process_blind(int width, int height, std::int64_t pts, std::int64_t duration = no_time,
                              bool discont = false);

  /// With Settings::points_from_start: the points' positions in the next frame, and their ids, which are below
  /// max_points. The first offer that is not empty starts them. Later ones count only once the stream is forgotten; the
  /// same ids are then reused. Belongs to the thread of process(); an offer lasts for one frame.
  void offer_start(std::vector<StartPoint> points);

  /// Also tracks x,y (in the next frame's pixels) from the next frame on. Returns its id; no_feature if x or y is not
  /// finite or max_points is reached.
  FeatureId add_point(double x, double y);
  /// Ends a feature with the next frame. False if the id is unknown or already removed.
  bool remove_point(FeatureId id);
  /// With the next frame, ends the feature in the picture whose last position is nearest, and returns it; no_feature if
  /// there is none.
  FeatureId remove_nearest(double x, double y);
  /// Forgets the stream: with the next frame all features end and new ones start, with new ids.
  void reset();

  Stats stats() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace csd
