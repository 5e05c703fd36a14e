// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <cstdint>
#include <vector>

#include "score/clip.h"

namespace csd::score {

/// Survival (PointOdyssey, CoTracker): a feature survives until a frame where it is visible but its position is more
/// than 50 pixels off, in a picture scaled by 255/(W−1), 255/(H−1). The share of surviving samples, including hidden
/// ones.
inline constexpr double survival_pixels = 50;

struct SurvivalSums {
  std::uint64_t alive = 0, labelled = 0;
};
/// One for each feature.
std::vector<SurvivalSums> survival_sums(const Clip &clip);

}  // namespace csd::score
