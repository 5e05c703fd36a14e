// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <opencv2/core.hpp>

#include <cstdint>
#include <vector>

#include "csd/recall.h"
#include "csd/steps.h"

namespace csd {

/// Tissue points of the tracker's own, spread over the picture: they measure the tissue's motion, so that a user's
/// point has the same track whichever other points there are.
///
/// As the view moves, empty cells of the picture get new points. A new point takes its reference coordinates from the
/// points around it, so all points of a stream share one chart: that of the frame in which the first began. It is used
/// only after it has moved with its neighbours for a while, because it may lie on a tool. If nothing has been visible
/// for a second (another scene), the next points start a new chart.
class SupportPoints {
 public:
  /// Tracks the points into the frame and updates field(), surroundings() and chart().
  void follow(const CsdFrame &frame);
  /// Drops points that are lost for good and starts new ones in empty cells.
  void replenish(const CsdFrame &frame);
  void clear();
  /// The stream has jumped: no point is visible until it is found again.
  void hide_until_found(const CsdFrame &frame);

  /// Of the established points that are reliable in this frame.
  const NeighbourField &field() const { return field_; }
  const Surroundings &surroundings() const { return surroundings_; }
  int chart() const { return chart_; }
  std::size_t size() const { return points_.size(); }

 private:
  struct Support : Followed {
    std::int64_t begun, covered;  ///< covered: when it was last visible, outside the picture, or its scene out of view
  };

  bool may_rest(const CsdFrame &frame, const Followed &support) const;
  bool searched_for(const CsdFrame &frame, const Followed &support) const;
  void rebuild_field(const CsdFrame &frame);
  void plan_search(const CsdFrame &frame);
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
  std::int64_t last_reliable_ = 0, last_begin_ = 0;
  double share_ = 1;                 // of the points: processed in this frame
  bool due_ = false;                 // a lost scene is searched for in this frame
  bool searching_ = true;            // all hidden points are searched for in this frame
  Points turns_;                     // scratch
  std::vector<double> changes_;      // scratch
  std::vector<cv::Point2d> near_;    // scratch
  cv::Mat level_, corners_, tools_;  // scratch
};

}  // namespace csd
