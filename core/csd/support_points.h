// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <opencv2/core.hpp>

#include <cstdint>
#include <vector>

#include "csd/recall.h"
#include "csd/steps.h"

namespace csd {

/// Points of the tissue that nobody asked for, spread over the picture: they say how it moves, so that a user's point
/// has the same track whichever other points there are.
///
/// As the view moves on, cells of the picture that no point covers get new ones. A new point takes its reference
/// coordinates from the points around it, so all of a stream lie in one chart: that of the frame in which the first
/// began. It counts only once it has moved with its neighbours for a while, for it may lie on a tool. Where nothing has
/// been seen for a second (another scene), the next points found a chart of their own.
class SupportPoints final : public Company {
 public:
  /// Follows the points into the frame; then field() and the others speak of it.
  void follow(const CsdFrame &frame);
  /// Drops points that are gone for good, begins new ones where none are.
  void replenish(const CsdFrame &frame);
  void clear();
  /// The stream has jumped: no point is visible until it has been found again.
  void doubt(const CsdFrame &frame);

  const NeighbourField &field() const override { return field_; }
  const Surroundings &surroundings() const override { return surroundings_; }
  int chart() const { return chart_; }
  std::size_t size() const { return points_.size(); }

 private:
  struct Support : Followed {
    std::int64_t begun, covered;  ///< covered: when it was last visible, out of the picture, or its scene out of view
  };

  std::size_t owner(const Followed &support) const override { return support.id; }
  bool alone() const override { return due_; }
  bool may_rest(const CsdFrame &frame, const Followed &support) const override;
  bool searched_for(const Followed &support) const override;
  void gather(const CsdFrame &frame) override;
  void met(const CsdFrame &frame) override;
  void looked(const CsdFrame &frame) override;

  void recall(const CsdFrame &frame);
  void sum_up(const CsdFrame &frame);
  void age(const CsdFrame &frame);
  void drop(const CsdFrame &frame);
  void begin(const CsdFrame &frame);

  std::vector<Support> points_;
  NeighbourField field_;
  Recall recall_;
  Surroundings surroundings_;
  int chart_ = -1;
  std::size_t next_id_ = 0, frames_ = 0;
  std::int64_t last_sure_ = 0, last_begin_ = 0;
  double share_ = 1;                 // of the points, that had their turn in this frame
  bool due_ = false;                 // a scene that is gone is looked for in this frame
  bool searching_ = true;            // all that is hidden is looked for in this frame
  std::size_t search_every_ = 1;     // frames, for what is hidden otherwise
  std::vector<Followed *> turns_;    // scratch
  std::vector<double> changes_;      // scratch
  std::vector<cv::Point2d> near_;    // scratch
  cv::Mat level_, corners_, tools_;  // scratch
};

}  // namespace csd
