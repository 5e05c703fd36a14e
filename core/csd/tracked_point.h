// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <optional>

#include "csd/likeness.h"
#include "csd/neighbour_map.h"
#include "csd/visibility.h"
#include "patch/align.h"
#include "patch/anchor_median.h"
#include "track/frame_budget.h"

namespace csd {

class WorkFrame;

/// A frame as `csd` looks at it.
struct CsdFrame {
  const Pyramid &pyramid;
  const GlareWeights &weights;
  cv::Size size;                      ///< of the working image
  double unit;                        ///< working pixels for a pixel of a 480-line picture: what constants are given in
  double steps;                       ///< frames of 40 ms since the last frame: what rates are given in
  std::int64_t time;                  ///< ns
  std::int64_t training_time;         ///< ns: how long an anchor is gathered
  double patch = 1;                   ///< working pixels to a sample of a patch (of 21 × 21) where a point begins
  FrameBudget budget = {};            ///< when it is spent, points wait
  const WorkFrame *colour = nullptr;  ///< tells tools from tissue, where new points begin; none: nothing does
  bool shows(cv::Point2d p) const {
    return p.x >= -0.5 && p.y >= -0.5 && p.x < size.width - 0.5 && p.y < size.height - 0.5;
  }
};

/// How the supporting points see a frame.
struct Surroundings {
  double gain_drift = 0, brightness_drift = 0;  ///< medians of the sure points' changes
  double blur = 0;                              ///< median of TrackedPoint::blur()
  bool alone = false;                           ///< there are hardly any: a point must do without a map
};

/// One point of tissue as `csd` follows it, a user's or a supporting one: its affine state, its frozen anchor, and its
/// place among its neighbours. All coordinates are the working image's.
///
/// In each frame: look(), meet(), look_again(), decide(), learn(), and freeze() when ripe(). A point that has to wait
/// for a later frame: pass() or rest(), meet(), wait().
class TrackedPoint {
 public:
  /// A supporting point may be less exact: it is one of many in a map, and their spread is half a pixel at least.
  enum class Purpose : std::uint8_t { query, support };

  TrackedPoint(const CsdFrame &frame, cv::Point2d position, Purpose purpose = Purpose::query);

  /// The point's coordinates in `chart` become where it is now.
  void found(int chart);
  /// The point gets coordinates in `chart` by the field's map, if there is one.
  void join(const NeighbourField &field, int chart, double unit);

  /// The first look: from where its own motion takes it, if it was visible in the last frame.
  void look(const CsdFrame &frame);
  /// Compares what was seen with the neighbours' map; what they contradict is not sure.
  void meet(const CsdFrame &frame, const NeighbourMap &map);
  /// With the field's map, whose points are those of others than `owner`.
  void meet(const CsdFrame &frame, const NeighbourField &field, std::size_t owner = NeighbourField::nobody);
  /// The second look, for what is not sure: from where the neighbours put it; without a map, if `alone`, from where it
  /// was seen last.
  void look_again(const CsdFrame &frame, bool alone);
  /// Is the point visible, and with which probability?
  void decide(const CsdFrame &frame, const Surroundings &around);
  /// Learns from this frame what decide() found visible: the anchor, the offset from the neighbours, the usual gain.
  void learn(const CsdFrame &frame);
  /// The training time is over: freeze() makes the anchor of its samples.
  bool ripe(const CsdFrame &frame) const { return learning() && frame.time - begun_ >= frame.training_time; }
  void freeze();

  /// Instead of look(): nobody looks at the point in this frame.
  void pass();
  /// Whether its neighbours know well enough where a point goes that was looked at in the last frame, so that it can
  /// rest() instead of look().
  bool may_rest(const CsdFrame &frame) const;
  void rest();
  /// Ends such a frame: the point goes where the neighbours put it, and belief in it fades; without a map it claims
  /// nothing.
  void wait(const CsdFrame &frame);
  /// How much a point should be looked at: frames of 40 ms since it was, twice that while it is unsure or fast.
  double urgency(const CsdFrame &frame) const;

  /// The next frame may show anything: the point isn't visible until it has been found again.
  void doubt();

  bool sure() const { return sure_; }        ///< seen well, and the neighbours agree
  bool visible() const { return visible_; }  ///< after decide()
  bool learning() const { return !medians_.empty(); }
  double confidence() const { return confidence_; }
  /// What decide() went by in this frame; nothing where there was nothing to judge.
  const std::optional<Evidence> &evidence() const { return evidence_; }
  const AffineState &state() const { return state_; }
  cv::Point2d seen_at() const { return fine_.state.position; }       ///< of a sure point, in this frame
  cv::Point2d expected_at() const { return prediction().position; }  ///< by the neighbours' map
  int chart() const { return chart_; }                               ///< −1: none
  cv::Point2d own_reference() const { return reference_ + offset_.offset(); }
  const NeighbourOffset &offset() const { return offset_; }
  const NeighbourMap &map() const { return map_; }
  /// Change of ln gain against the usual; nothing if none is known.
  std::optional<double> gain_change() const;
  std::optional<double> brightness_change() const;  ///< the same of the patch's mean, grey levels
  /// How much more of the finest level's contrast is gone than of the next coarser one's, ln: smoke dims both alike, a
  /// wet lens takes fine detail first. 0 where contrast is as usual; nothing of what doesn't look like the point.
  std::optional<double> blur() const;

 private:
  AffineState prediction() const { return offset_.predict(map_, reference_); }
  int finest_level(double zoom) const;
  void set_anchor(int level, const AnchorLevel &anchor);
  void locate(const CsdFrame &frame, const AffineState &start, double position_sd, int top, bool core);
  void weigh_coarser(const CsdFrame &frame);
  void judge(const CsdFrame &frame);
  double likeness_there(double unit) const;
  bool told_apart(double unit) const;
  cv::Point2d fused(const CsdFrame &frame) const;

  Purpose purpose_;
  AffineState state_;
  /// How far from where its motion put it the last first look found it, working pixels in 40 ms.
  double missed_ = std::numeric_limits<double>::infinity();
  cv::Point2d velocity_;  ///< of the last frame, working pixels in 40 ms
  Anchor anchor_;
  std::array<double, Anchor::coarsest - Anchor::finest + 1> unmasked_{};  ///< share of the anchor's levels
  std::vector<AnchorMedian> medians_;                                     ///< while it is learning: levels 0…2
  std::optional<Likeness> likeness_;                                      ///< once it was seen with its frozen anchor
  double contrast_ = 0;                                                   ///< of the finest level, sd in grey levels
  std::int64_t begun_, last_sample_, last_look_;

  int chart_ = -1;
  cv::Point2d reference_;
  NeighbourOffset offset_;
  NeighbourMap map_;  ///< of this frame, after meet()
  double nearby_ = NeighbourMap().nearby;
  // Running means of ln gain, of ln noise in the picture's grey levels, and of the patch's mean.
  double usual_gain_ = 0, usual_noise_ = 0, usual_brightness_ = 0;
  bool usual_known_ = false;

  // Of this frame.
  Alignment fine_;
  AffineState aligned_;  ///< by the patch alone: a new anchor that were taken where the neighbours pull would stay off
  double zncc_coarse_ = 0, gain_coarse_ = 0;  ///< gain 0: not looked at
  double distance_ = 0;                       ///< from where the neighbours put it, reference pixels at 480 lines
  bool agrees_ = true;
  bool own_motion_ = false;  ///< against the neighbours, by what tells it apart
  bool core_ = false;        ///< aligned by its inner disc
  bool sure_ = true, visible_ = true, again_ = false;
  bool pressing_ = true;  ///< visible, and unsure or fast when it was last looked at
  double confidence_ = 1;
  std::optional<Evidence> evidence_;
};

}  // namespace csd
