// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <memory>
#include <vector>

#include "base/types.h"
#include "image/work_frame.h"
#include "track/executor.h"
#include "track/frame_budget.h"
#include "track/settings.h"

namespace csd {

/// The input of an algorithm for one frame.
struct FrameContext {
  const WorkFrame &frame;
  const cv::Mat &forbidden;  ///< CV_8UC1, working size, 255 where learning is forbidden; empty: nowhere
  std::int64_t time;         ///< ns since the tracker was created; never decreases
  bool jumped = false;       ///< the stream is discontinuous here: the view may have changed
  FrameBudget budget = {};   ///< of the tracking of this frame
  cv::Rect2d bounds() const {
    return {-0.5, -0.5, static_cast<double>(frame.picture_size().width),
            static_cast<double>(frame.picture_size().height)};
  }
};

/// An algorithm's result for one feature in one frame.
struct Claim {
  enum class Kind : std::uint8_t {
    learning,  ///< visible, by the recursive start
    tracked,   ///< visible
    hidden,    ///< not visible, may return
    lost,      ///< not visible; given up, or searched for for long
    out        ///< outside the picture
  };
  FeatureId id = 0;
  Kind kind = Kind::hidden;
  cv::Point2d position;     ///< picture pixels; in: the last one, out: the current one (hidden: a prediction)
  double confidence = 1;    ///< of `learning` and `tracked`: at least .5; of `hidden`: below that, if known
  bool fresh = true;        ///< false: the frame's budget was spent before the feature was searched for
  bool surrounded = false;  ///< the tissue around it is visible: if it is hidden, it is hidden alone
};

/// Finds positions: csd, csd-2012 or one of the baselines. The Tracker owns one, starts and ends its features, and
/// turns its claims into states. All calls come from the Tracker's thread, per frame in the order track, begin/end…,
/// finish.
class Algorithm {
 public:
  virtual ~Algorithm() = default;

  /// Whether new features replace ended ones. (Not in the paper's tracker and its baselines.)
  virtual bool replenishes() const { return false; }
  /// Whether detection avoids what looks like a tool by colour. (Not in the paper.)
  virtual bool avoids_tools() const { return false; }
  /// Detection rejects places more similar than this to the tissue around them: LookAlikes::best(). 1: none.
  virtual double max_look_alike() const { return 1; }

  /// Fills in the claims of the features that have begun; `claims` is sorted by ascending id.
  virtual void track(const FrameContext &context, std::vector<Claim> &claims) = 0;
  /// Starts a feature at `position` in this frame (picture pixels, inside the picture). Returns its first state,
  /// `learning` or `tracked`.
  virtual Claim::Kind begin(FeatureId id, cv::Point2d position, const FrameContext &context) = 0;
  virtual void end(FeatureId id) = 0;
  /// Ends the frame: pixels that are still needed must be copied now.
  virtual void finish(const FrameContext &context) = 0;
  /// Forgets the stream, all features and the last frame.
  virtual void forget() = 0;
  /// Adds its counters to `stats`. Called from any thread.
  virtual void add_to(Stats &stats) const = 0;
};

}  // namespace csd
