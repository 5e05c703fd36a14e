// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <vector>

#include "csd/tracked_point.h"

namespace csd {

/// A point in a list of tracked points.
struct Followed {
  /// What happens to it in a frame: it is aligned; it follows its neighbours' map; it waits because the budget is
  /// spent.
  enum class Turn : std::uint8_t { aligns, rests, waits };

  TrackedPoint point;
  std::size_t id;
  bool established = false;  ///< other points' maps may use it
  Turn turn = Turn::aligns;
};

/// Shares of a frame's budget, both from its start: for first alignments, and for all of them. `least` points are
/// aligned whatever the budget, `more` while fewer are reliable than a map uses.
struct Shares {
  double first = 1, all = 1;
  std::size_t least = 1, more = 1;
};

using Points = std::vector<Followed *>;
using Choice = std::function<bool(const Followed &)>;
/// Whether a field holds the points that are compared with it.
enum class Among : std::uint8_t {
  others,      ///< it holds others alone
  themselves,  ///< the points are in the field; each is left out of its own map
};

// The steps of a frame, in this order, for a list of points: the user's or the supporting ones. Within a step points
// are independent, and tracked in parallel unless there is a budget. docs/method.md, "How a frame is processed".

/// With a budget, the most urgent points come first: when it is spent, the others wait.
void order_by_urgency(const CsdFrame &frame, Points &points);
/// Each point is aligned from where its own motion predicts it, or rests if `may_rest`. Past the budget the rest wait.
void first_alignments(const CsdFrame &frame, const Points &points, const Shares &shares, const Choice &may_rest = {});
/// Each point is compared with the map of its neighbours in `field`.
void compare_with_maps(const CsdFrame &frame, const Points &points, const NeighbourField &field, Among among);
/// Unreliable points are aligned again, from their maps' predictions; without a map and if `alone`, from where they
/// were last visible. Hidden ones only if `searched_for`.
void second_alignments(const CsdFrame &frame, const Points &points, const Shares &shares, bool alone,
                       const Choice &searched_for = {});
/// Points without a map have been aligned on their own: they are compared with the field that these make. Chance
/// matches rarely agree on a motion.
void compare_unmapped(const CsdFrame &frame, const Points &points, const NeighbourField &field, Among among);
/// Whether each point is visible, and where. A point that rests or waits follows its map.
void decide_visibility(const CsdFrame &frame, const Points &points, const Surroundings &around);
/// Aligned points update their models. Anchors whose training time is over are frozen, as long as the budget lasts.
void update_models(const CsdFrame &frame, const Points &points);

}  // namespace csd
