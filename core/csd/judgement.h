// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <optional>

#include "csd/look.h"
#include "csd/neighbour_map.h"
#include "csd/visibility.h"

namespace csd {

/// What its neighbours say of a point.
struct Expectation {
  NeighbourMap map;      ///< none: nobody says anything, and the rest is void
  AffineState state;     ///< where and in which shape they put it
  double deviation = 0;  ///< NeighbourOffset::deviation()

  explicit operator bool() const { return static_cast<bool>(map); }
  bool overrules(const Tuning &tuning) const { return map.support >= count(tuning.min_judges); }
};

/// Whom to believe: what was seen, or the neighbours.
struct Judgement {
  bool sure = false;        ///< seen well, and the neighbours agree
  bool agrees = true;       ///< the neighbours do, or have no say
  bool own_motion = false;  ///< it moves against the neighbours, and what tells it apart says that it may
  double distance = 0;      ///< from where the neighbours put it, reference px
};
/// `memory`: of the point. All that decides is in the arguments.
Judgement judge(const CsdFrame &frame, const Look &look, const Memory &memory, const Expectation &expected);

/// The patch has no look-alike where the neighbours put the point: it needs nobody's word.
bool told_apart(const CsdFrame &frame, const Look &look, const Memory &memory, const Expectation &expected);

/// The patch's own place, weighed against where the neighbours put it, each by what it knows (a MAP estimate). Along an
/// edge a patch knows next to nothing, however little noise there is: what bends or lies at another depth shifts it
/// there.
cv::Point2d fuse(const CsdFrame &frame, const Look &look, const Expectation &expected);

/// What speaks for the point being visible where it was seen; nothing where it can't be.
std::optional<Evidence> evidence_for(const CsdFrame &frame, const Look &look, const Memory &memory,
                                     const Expectation &expected, const Judgement &judgement,
                                     const Surroundings &around);

}  // namespace csd
