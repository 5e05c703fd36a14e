// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <memory>

#include "image/frame_view.h"
#include "track/types.h"

namespace csd {

class Algorithm;

/// Tracks many features through a stream of frames: finds them, lets the algorithm follow them, keeps their states.
///
/// process() belongs to one thread. add_point(), remove_point(), remove_nearest(), reset() and stats() may be called
/// from any thread and never wait for a frame. Trackers share nothing with each other.
class Tracker {
 public:
  /// `algorithm`: that of the settings, by make_algorithm(), or one that a test or an experiment has made.
  Tracker(const Settings &settings, std::unique_ptr<Algorithm> algorithm);
  ~Tracker();

  /// Tracks all features into the next frame. `pts` and `duration` in ns, no_time where unknown (then 25 frames a
  /// second are assumed). A change of the picture's size forgets the stream. The result is valid until the next call.
  /// `discont`: the frame does not follow on the last one. So is taken, too, a `pts` more than half a second off.
  /// Throws cv::Exception, std::bad_alloc, also those of a learner; the tracker may be used on after that.
  const Tracks &process(const FrameView &view, std::int64_t pts, std::int64_t duration = no_time, bool discont = false);

  /// What process() would have said if nothing could be seen: every feature that is not out or ended is lost. Right
  /// after a process() or process_blind() that threw it is about the same frame, and time does not go on.
  const Tracks &process_blind(int width, int height, std::int64_t pts, std::int64_t duration = no_time,
                              bool discont = false);

  /// With Settings::points_from_start: where points are in the next frame, and their ids, which are below max_points.
  /// The first offer that isn't empty begins them; later ones count only after the stream has been forgotten, and the
  /// same ids then come again. Belongs to the thread of process(); an offer lasts for one frame.
  void offer_start(std::vector<StartPoint> points);

  /// From the next frame on also track x,y (that frame's pixels). Returns its id; no_feature if x or y is not finite or
  /// max_points is reached.
  FeatureId add_point(double x, double y);
  /// Ends a feature with the next frame. False if there is none of that id, or it is removed already.
  bool remove_point(FeatureId id);
  /// Ends, with the next frame, that feature in the picture whose last position is nearest; no_feature if there is
  /// none.
  FeatureId remove_nearest(double x, double y);
  /// Forgets the stream: with the next frame all features end and new ones begin, under new ids.
  void reset();

  Stats stats() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace csd
