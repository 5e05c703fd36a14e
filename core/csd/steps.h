// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "csd/tracked_point.h"

namespace csd {

/// A point in a list of tracked points.
struct Followed {
  /// What happens to it in a frame: it is aligned; it follows its neighbours' map; it waits because the budget is
  /// spent.
  enum class Turn : std::uint8_t { looks, rests, waits };

  TrackedPoint point;
  std::size_t id;
  bool established = false;  ///< other points' maps may use it
  Turn turn = Turn::looks;
};

/// The neighbours of a list of points while a frame is processed. They are given for the user's points. The supporting
/// points are their own neighbours, so their field is rebuilt whenever some have been aligned.
class Company {
 public:
  virtual ~Company() = default;
  virtual const NeighbourField &field() const = 0;
  virtual const Surroundings &surroundings() const = 0;
  /// The owner whose points a point's own map excludes.
  virtual std::size_t owner(const Followed &) const { return NeighbourField::nobody; }
  /// Without a map, second alignments start at the last visible position.
  virtual bool alone() const { return surroundings().alone; }

  virtual bool may_rest(const CsdFrame &, const Followed &) const { return false; }
  virtual bool searched_for(const Followed &) const { return true; }  ///< search for a hidden point now?

  virtual void gather(const CsdFrame &) {}  ///< rebuilds the field from the points that are reliable now
  virtual void met(const CsdFrame &) {}     ///< called when all points have been compared with their first maps
  virtual void looked(const CsdFrame &) {}  ///< called when all points have been aligned
};

/// Shares of a frame's budget, both from its start: for first alignments, and for all of them. `least` points are
/// aligned whatever the budget, `more` while fewer are reliable than a map uses.
struct Shares {
  double first = 1, all = 1;
  std::size_t least = 1, more = 1;
};

/// Tracks points through a frame, the user's or supporting ones. When the budget is spent, the least urgent points
/// wait.
///
/// Each point is aligned from where its own motion predicts it and compared with its neighbours' map. If it is not
/// reliable, it is aligned again from the map's prediction. Then its visibility is decided and its model updated. Sorts
/// `points` by urgency.
void follow(const CsdFrame &frame, std::vector<Followed *> &points, Company &company, const Shares &shares);

}  // namespace csd
