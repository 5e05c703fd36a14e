// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <memory>
#include <vector>

#include "image/work_frame.h"
#include "track/executor.h"
#include "track/frame_budget.h"
#include "track/types.h"

namespace csd {

/// One frame as an algorithm sees it.
struct FrameContext {
  const WorkFrame &frame;
  const cv::Mat &forbidden;  ///< CV_8UC1, working size, 255 where nothing may be learnt; empty: nowhere
  std::int64_t time;         ///< ns since the tracker was made; never goes back
  bool jumped = false;       ///< the stream did not go on to here from the last frame: what it shows may be elsewhere
  FrameBudget budget = {};   ///< what tracking this frame may take
  cv::Rect2d bounds() const {
    return {-0.5, -0.5, static_cast<double>(frame.picture_size().width),
            static_cast<double>(frame.picture_size().height)};
  }
};

/// What an algorithm says of one feature in one frame.
struct Claim {
  enum class Kind : std::uint8_t {
    learning,  ///< seen, by the recursive start
    tracked,   ///< seen
    hidden,    ///< not seen, may come back
    lost,      ///< not seen, the algorithm has given it up or has been looking for long
    out        ///< beyond the edge of the picture
  };
  FeatureId id = 0;
  Kind kind = Kind::hidden;
  cv::Point2d position;     ///< picture pixels; in: the last one, out: where it is (hidden: a prediction)
  double confidence = 1;    ///< of `learning` and `tracked`, at least .5; of `hidden`: below that, if anything is known
  bool fresh = true;        ///< false: the frame's budget was spent before the feature could be looked for
  bool surrounded = false;  ///< the tissue around it was seen: what is hidden then is hidden by itself
};

/// How positions are found: csd-2012 or one of the baselines. The Tracker owns one, tells it which features there are,
/// and turns its claims into states; all calls come from the Tracker's thread, for each frame in the order track,
/// begin/end…, finish.
class Algorithm {
 public:
  virtual ~Algorithm() = default;

  /// May new features take the place of those that ended? (The paper's tracker and its baselines do not.)
  virtual bool replenishes() const { return false; }
  /// Does detection leave alone what colour says is a tool? (The paper's doesn't.)
  virtual bool avoids_tools() const { return false; }
  /// Detection leaves alone what looks more than this like the tissue around it: LookAlikes::best(). 1: nothing.
  virtual double max_likeness() const { return 1; }

  /// Fills in the claims of the features that have begun; `claims` is by ascending id.
  virtual void track(const FrameContext &context, std::vector<Claim> &claims) = 0;
  /// In this frame the feature is at `position` (picture pixels, inside the picture). Returns what it is to be called:
  /// `learning` or `tracked`.
  virtual Claim::Kind begin(FeatureId id, cv::Point2d position, const FrameContext &context) = 0;
  virtual void end(FeatureId id) = 0;
  /// Everything about this frame has been said: what has to be kept of its pixels must be copied now.
  virtual void finish(const FrameContext &context) = 0;
  /// Forgets the stream: no features, no last frame.
  virtual void forget() = 0;
  /// Adds what it counts to `stats`. Called from any thread.
  virtual void add_to(Stats &stats) const = 0;
};

}  // namespace csd
