// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <cstdint>
#include <limits>
#include <optional>

#include "csd/judgement.h"
#include "csd/memory.h"

namespace csd {

/// One point of tissue as `csd` follows it, a user's or a supporting one: its affine state, its memory, its place among
/// its neighbours, and what the present frame has shown of it. All coordinates are the working image's.
///
/// follow() in steps.h takes a point through a frame.
class TrackedPoint {
 public:
  /// A supporting point may be less exact: it is one of many in a map.
  enum class Purpose : std::uint8_t { query, support };

  TrackedPoint(const CsdFrame &frame, cv::Point2d position, Purpose purpose = Purpose::query);

  /// The point's coordinates in `chart` become where it is now.
  void found(int chart);
  /// The point gets coordinates in `chart` by the field's map, if there is one.
  void join(const NeighbourField &field, int chart, const CsdFrame &frame);

  /// The first look: from where its own motion takes it, if it was visible in the last frame.
  void look(const CsdFrame &frame);
  /// Compares what was seen with the neighbours' map; what they contradict is not sure.
  void meet(const CsdFrame &frame, const NeighbourMap &map);
  /// With the field's map, whose points are those of others than `owner`.
  void meet(const CsdFrame &frame, const NeighbourField &field, std::size_t owner = NeighbourField::nobody);
  /// The second look, for what is not sure: from where the neighbours put it; without a map, if `alone`, from where it
  /// was seen last.
  void look_again(const CsdFrame &frame, bool alone);
  /// Is the point visible, and with which probability? And where is it?
  void decide(const CsdFrame &frame, const Surroundings &around);
  /// Learns from this frame what decide() found visible: the anchor, the offset from the neighbours, the usual gain.
  void learn(const CsdFrame &frame);
  bool ripe(const CsdFrame &frame) const { return memory_.ripe(frame); }
  void freeze() { memory_.freeze(); }

  /// Instead of look(): nobody looks at the point in this frame.
  void pass();
  /// Whether its neighbours know well enough where a point goes that was looked at in the last frame, so that it can
  /// rest() instead of look().
  bool may_rest(const CsdFrame &frame) const;
  void rest();
  /// Ends such a frame: the point goes where the neighbours put it, and belief in it fades; without a map it claims
  /// nothing.
  void wait(const CsdFrame &frame);
  /// How much a point should be looked at: ns since it was, twice that while it is unsure or fast.
  double urgency(const CsdFrame &frame) const;

  /// The next frame may show anything: the point isn't visible until it has been found again.
  void doubt();

  bool sure() const { return judgement_.sure; }  ///< seen well, and the neighbours agree
  bool visible() const { return visible_; }      ///< after decide()
  bool learning() const { return memory_.learning(); }
  double confidence() const { return confidence_; }
  /// What decide() went by in this frame; nothing where there was nothing to judge.
  const std::optional<Evidence> &evidence() const { return evidence_; }
  const AffineState &state() const { return state_; }
  cv::Point2d seen_at() const { return look_.fine.state.position; }  ///< of a sure point, in this frame
  /// By the neighbours' map.
  cv::Point2d expected_at() const { return offset_.predict(map_, reference_).position; }
  int chart() const { return chart_; }  ///< −1: none
  cv::Point2d own_reference() const { return reference_ + offset_.offset(); }
  const NeighbourOffset &offset() const { return offset_; }
  const NeighbourMap &map() const { return map_; }
  std::optional<double> gain_change() const { return memory_.gain_change(look_.fine); }
  std::optional<double> brightness_change() const { return memory_.brightness_change(look_.fine); }
  /// How much more of the finest level's contrast is gone than of the next coarser one's, ln: smoke dims both alike, a
  /// wet lens takes fine detail first. 0 where contrast is as usual; nothing of what doesn't look like the point.
  std::optional<double> blur(const Tuning &tuning) const;

 private:
  Expectation expectation(const Tuning &tuning) const;
  void see(const CsdFrame &frame, const Look &look);

  Purpose purpose_;
  AffineState state_;
  Memory memory_;
  cv::Point2d velocity_;  ///< of the last frame, working pixels in 40 ms
  /// How far from where its motion put it the last first look found it, working pixels in 40 ms.
  double missed_ = std::numeric_limits<double>::infinity();
  bool visible_ = true, pressing_ = true;  ///< pressing: visible, and unsure or fast when it was last looked at
  double confidence_ = 1;
  std::int64_t last_look_;

  // Its place among its neighbours.
  int chart_ = -1;
  cv::Point2d reference_;
  NeighbourOffset offset_;
  NeighbourMap map_;  ///< of this frame, after meet()
  double nearby_ = NeighbourMap().nearby;

  // Of this frame.
  Look look_;
  Judgement judgement_;
  AffineState aligned_;  ///< by the patch alone: a new anchor that were taken where the neighbours pull would stay off
  std::optional<Evidence> evidence_;
};

}  // namespace csd
