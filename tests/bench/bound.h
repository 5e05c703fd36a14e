// SPDX-License-Identifier: LGPL-2.1-or-later
// The limit of what csd's patches can reach.
#pragma once

#include "bench/sequences.h"

namespace csd::bench {

/// Of the visible samples, the shares that an alignment finds within 2 and 5 px of the truth when it starts at the
/// true place. No tracker, but the limit of any tracker that relies on such a patch.
struct Bound {
  double within_2 = 0, within_5 = 0;
  /// Of all alignments that seem reliable (ZNCC of both levels ≥ .6, half of the patch fits), including those at hidden
  /// points, the share that is wrong.
  double wrong = 0;
};
/// Collects each point's anchor at its true places for half a second. Then aligns it in each frame from the true place,
/// in the shape given by the true motion of the points around it.
Bound align_from_truth(const Rendered &rendered);

}  // namespace csd::bench
