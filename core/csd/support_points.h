// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <opencv2/core.hpp>

#include <cstdint>
#include <vector>

#include "csd/recall.h"
#include "csd/tracked_point.h"

namespace csd {

/// Points of the tissue that nobody asked for, spread over the picture: they say how it moves, so that a user's point
/// has the same track whichever other points there are.
///
/// As the view moves on, cells of the picture that no point covers get new ones. A new point takes its reference
/// coordinates from the points around it, so all of a stream lie in one chart: that of the frame in which the first
/// began. It counts only once it has moved with its neighbours for a while, for it may lie on a tool. Where nothing has
/// been seen for a second (another scene), the next points found a chart of their own.
class SupportPoints {
 public:
  /// Follows the points into the frame; then field() and the others speak of it. Past the frame's budget those wait
  /// that are least urgent, but for the few without which there would be no map.
  void follow(const CsdFrame &frame);
  /// Drops points that are gone for good, begins new ones where none are.
  void replenish(const CsdFrame &frame);
  void clear();
  /// The stream has jumped: no point is visible until it has been found again.
  void doubt(const CsdFrame &frame);

  const NeighbourField &field() const { return field_; }
  const Surroundings &surroundings() const { return surroundings_; }
  int chart() const { return chart_; }
  std::size_t size() const { return points_.size(); }

 private:
  struct Support {
    TrackedPoint point;
    std::int64_t begun, covered;  ///< covered: when it was last visible, out of the picture, or its scene out of view
    bool established;             ///< its neighbours believe it
    std::size_t id;
    bool waits = false;  ///< for a later frame
  };

  void look(const CsdFrame &frame);
  void collect();
  void recall(const CsdFrame &frame);
  void sum_up(const CsdFrame &frame);
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
  std::vector<Support *> turns_;     // scratch: by falling urgency
  std::vector<double> changes_;      // scratch
  std::vector<cv::Point2d> near_;    // scratch
  cv::Mat level_, corners_, tools_;  // scratch
};

}  // namespace csd
