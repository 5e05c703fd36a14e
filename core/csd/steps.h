// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "csd/tracked_point.h"

namespace csd {

/// A point in a list that is followed.
struct Followed {
  /// What happens to it in a frame: it is looked at; its neighbours know the way well enough; the budget is spent.
  enum class Turn : std::uint8_t { looks, rests, waits };

  TrackedPoint point;
  std::size_t id;
  bool established = false;  ///< others' maps may stand on it
  Turn turn = Turn::looks;
};

/// What the points of a list have around them while a frame is followed. For a user's points it is given; the
/// supporting points make it themselves, and so make it anew whenever some of them have been seen.
class Company {
 public:
  virtual ~Company() = default;
  virtual const NeighbourField &field() const = 0;
  virtual const Surroundings &surroundings() const = 0;
  /// Whose points a point's own map must not stand on.
  virtual std::size_t owner(const Followed &) const { return NeighbourField::nobody; }
  /// Second looks without a map begin where a point was seen last.
  virtual bool alone() const { return surroundings().alone; }

  virtual bool may_rest(const CsdFrame &, const Followed &) const { return false; }
  virtual bool searched_for(const Followed &) const { return true; }  ///< what is hidden, in this frame

  virtual void gather(const CsdFrame &) {}  ///< the field, of what is sure now
  virtual void met(const CsdFrame &) {}     ///< all have compared themselves with their first maps
  virtual void looked(const CsdFrame &) {}  ///< all have been looked at
};

/// Of a frame's budget, from its begin: how much is for first looks, and how much for all of them; and how many points
/// are looked at whatever the budget, more while fewer are seen than a map stands on.
struct Shares {
  double first = 1, all = 1;
  std::size_t least = 1, more = 1;
};

/// Takes points through a frame; a user's and supporting ones alike. Past the budget those wait that are least urgent.
///
/// Each is looked at from where its own motion takes it; meets its neighbours' map; where it is not sure, is looked at
/// again from where they put it; decides whether it is visible; and learns. `points` are put into the order of their
/// turns.
void follow(const CsdFrame &frame, std::vector<Followed *> &points, Company &company, const Shares &shares);

}  // namespace csd
