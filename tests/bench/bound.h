// SPDX-License-Identifier: LGPL-2.1-or-later
// What csd's patches could reach at best.
#pragma once

#include "bench/sequences.h"

namespace csd::bench {

/// Shares of the visible samples that a look finds within 2 and 5 px of the truth when it begins at the true place: no
/// tracker, but what limits any that believes such a patch.
struct Bound {
  double within_2 = 0, within_5 = 0;
  /// Of all looks that seem sure (ZNCC of both levels ≥ .6, half of the patch fits), at hidden points too, the share
  /// that is wrong.
  double wrong = 0;
};
/// Each point's anchor is gathered at its true places for half a second; then each frame is looked at from the true
/// place, in the shape that the true motion of the points around it gives.
Bound look_from_truth(const Rendered &rendered);

}  // namespace csd::bench
