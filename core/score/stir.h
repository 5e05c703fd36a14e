// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <span>

#include "score/jaccard.h"

namespace csd::score {

/// The STIR challenge of 2026: AJ, accuracy on the visible (ATA, here delta_avg), OA; strictly below these pixels of
/// the picture itself; the first labelled frame is left out; all clips pooled.
inline constexpr Thresholds stir_2026_pixels{2, 4, 8, 16, 32};
JaccardSums stir_2026_sums(const Clip &clip);

/// The STIR challenges of 2024 and 2025 know no identities: from where each start point was tracked to, the distance to
/// the *nearest* end point; shares at most so many pixels off, and their mean; all clips pooled.
inline constexpr Thresholds stir_2024_pixels{4, 8, 16, 32, 64};
struct Stir2024Score {
  double delta_avg = unknown;
  Thresholds within{unknown, unknown, unknown, unknown, unknown};
};
/// Distances of `points` to the nearest of clip.ends; infinite ones are infinitely far. Nothing if there are no ends.
std::vector<double> end_distances(const Clip &clip, std::span<const cv::Point2d> points);
Stir2024Score stir_2024_score(std::span<const double> distances);

}  // namespace csd::score
