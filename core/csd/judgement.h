// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <optional>

#include "csd/neighbour_map.h"
#include "csd/point_alignment.h"
#include "csd/visibility.h"

namespace csd {

/// What the neighbours' map predicts for a point.
struct Expectation {
  NeighbourMap map;      ///< empty: no prediction, the other fields are invalid
  AffineState state;     ///< predicted position and shape
  double deviation = 0;  ///< NeighbourOffset::deviation()

  explicit operator bool() const { return static_cast<bool>(map); }
  bool may_veto(const Tuning &tuning) const { return map.support >= count(tuning.min_judges); }
};

/// How the alignment compares with the neighbours' map.
struct Judgement {
  bool reliable = false;    ///< aligned well and no veto
  bool vetoed = false;      ///< the map contradicts and counts
  bool own_motion = false;  ///< disagrees with the map, but the patch is distinctive
  double distance = 0;      ///< from the predicted position, reference px
};
/// `memory`: the point's. The result depends on the arguments alone.
Judgement judge(const CsdFrame &frame, const PointAlignment &alignment, const Memory &memory,
                const Expectation &expected);

/// The patch is distinctive: nothing similar lies near the predicted position. It needs no support from the map.
bool is_distinctive(const CsdFrame &frame, const PointAlignment &alignment, const Memory &memory,
                    const Expectation &expected);

/// Fuses the aligned and the predicted position by their covariances (a MAP estimate). Along an edge, a patch has
/// almost no position information even without noise: deformation and parallax shift it there.
cv::Point2d fuse(const CsdFrame &frame, const PointAlignment &alignment, const Expectation &expected);

/// The evidence that the point is visible at its aligned position; empty if it cannot be.
std::optional<Evidence> evidence_for(const CsdFrame &frame, const PointAlignment &alignment, const Memory &memory,
                                     const Expectation &expected, const Judgement &judgement,
                                     const Surroundings &around);

}  // namespace csd
