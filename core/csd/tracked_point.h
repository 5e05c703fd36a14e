// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <cstdint>
#include <limits>
#include <optional>

#include "csd/judgement.h"
#include "csd/memory.h"

namespace csd {

/// A tissue point tracked by `csd`, the user's or a supporting one: its affine state, appearance model and reference
/// coordinates, and its result in the current frame. All coordinates are working pixels.
///
/// steps.h tracks a list of points through a frame.
class TrackedPoint {
 public:
  /// A supporting point may be less accurate: it is one of many in a map.
  enum class Purpose : std::uint8_t { query, support };

  TrackedPoint(const CsdFrame &frame, cv::Point2d position, Purpose purpose = Purpose::query);

  /// Starts `chart` at the point: its reference coordinates become its current position.
  void begin_chart(int chart);
  /// Gives the point coordinates in `chart` by the field's inverse map, if there is one.
  void enter_chart(const NeighbourField &field, int chart, const CsdFrame &frame);

  /// The first alignment: from where its own motion predicts it, if it was visible in the last frame.
  void first_alignment(const CsdFrame &frame);
  /// Compares the alignment with the neighbours' map. A contradiction makes it unreliable.
  void compare_with_map(const CsdFrame &frame, const NeighbourMap &map);
  /// With the field's map, which excludes the points of `owner`.
  void compare_with_map(const CsdFrame &frame, const NeighbourField &field, std::size_t owner = NeighbourField::nobody);
  /// The second alignment of an unreliable point: from the map's prediction; without a map and if `alone`, from where
  /// it was last visible.
  void second_alignment(const CsdFrame &frame, bool alone);
  /// Decides whether the point is visible, with which probability, and where.
  void decide_visibility(const CsdFrame &frame, const Surroundings &around);
  /// Updates from a visible point: the anchor, the offset from the map, the usual gain.
  void update(const CsdFrame &frame);
  bool training_over(const CsdFrame &frame) const { return memory_.training_over(frame); }
  void freeze_anchor() { memory_.freeze_anchor(); }

  /// Instead of first_alignment(): the point is not aligned in this frame.
  void wait();
  /// Whether the neighbours predict the point, which was aligned in the last frame, well enough that it can rest()
  /// instead of first_alignment().
  bool may_rest(const CsdFrame &frame) const;
  void rest();
  /// Ends such a frame: the point moves to the map's prediction and its confidence decays. Without a map it claims
  /// nothing.
  void follow_map(const CsdFrame &frame);
  /// Priority of an alignment: ns since the last one, doubled while the point is unreliable or fast.
  double urgency(const CsdFrame &frame) const;

  /// The next frame may show anything: the point is invisible until it is found again.
  void hide_until_found();

  bool reliable() const { return judgement_.reliable; }  ///< aligned well and no veto
  bool visible() const { return visible_; }              ///< after decide_visibility()
  bool learning() const { return memory_.learning(); }
  double confidence() const { return confidence_; }
  /// The evidence behind decide_visibility() in this frame; empty if there was none.
  const std::optional<Evidence> &evidence() const { return evidence_; }
  const AffineState &state() const { return state_; }
  cv::Point2d seen_at() const { return alignment_.fine.state.position; }  ///< of a reliable point, in this frame
  /// As the neighbours' map predicts.
  cv::Point2d expected_at() const { return offset_.predict(map_, reference_).position; }
  int chart() const { return chart_; }  ///< −1: none
  cv::Point2d own_reference() const { return reference_ + offset_.offset(); }
  const NeighbourOffset &offset() const { return offset_; }
  const NeighbourMap &map() const { return map_; }
  std::optional<double> gain_change() const { return memory_.gain_change(alignment_.fine); }
  std::optional<double> brightness_change() const { return memory_.brightness_change(alignment_.fine); }
  /// ln of the contrast lost at the finest level beyond that lost at the next coarser one. Smoke dims both alike; a wet
  /// lens removes fine detail first. 0 at usual contrast; empty if the patch does not look like the point.
  std::optional<double> blur(const Tuning &tuning) const;

 private:
  Expectation expectation(const Tuning &tuning) const;
  void set_alignment(const CsdFrame &frame, const PointAlignment &alignment);

  Purpose purpose_;
  AffineState state_;
  Memory memory_;
  cv::Point2d velocity_;  ///< of the last frame, working pixels in 40 ms
  /// Distance of the last first alignment from its predicted position, working pixels in 40 ms.
  double missed_ = std::numeric_limits<double>::infinity();
  bool visible_ = true, pressing_ = true;  ///< pressing: visible, and unreliable or fast when last aligned
  double confidence_ = 1;
  std::int64_t last_alignment_;

  // Relation to its neighbours.
  int chart_ = -1;
  cv::Point2d reference_;
  NeighbourOffset offset_;
  NeighbourMap map_;  ///< of this frame, after compare_with_map()
  double nearby_ = NeighbourMap().nearby;

  // Of this frame.
  PointAlignment alignment_;
  Judgement judgement_;
  AffineState aligned_;  ///< from the patch alone: an anchor sampled at the fused position would keep that bias
  std::optional<Evidence> evidence_;
};

}  // namespace csd
