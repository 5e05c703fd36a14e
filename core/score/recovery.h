// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <cstdint>
#include <vector>

#include "score/clip.h"

namespace csd::score {

/// A feature that was visible, then hidden or outside, and is visible again: the delay until a claim within τ.
struct Recovery {
  bool recovered = false;  ///< before the feature was hidden again or the labels ended
  std::uint64_t frames = 0;
  std::int64_t time = no_time;  ///< ns; no_time if the truth has no pts
};

/// One for each return, by feature and time. The delay counts from the first labelled frame in which the feature is
/// visible again, so it is 0 if the tracker claims it at once. Unlabelled frames don't count as hidden or visible.
std::vector<Recovery> recoveries(const Clip &clip, double tau);

}  // namespace csd::score
