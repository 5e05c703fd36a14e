// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <span>

#include "score/jaccard.h"

namespace csd::score {

/// The STIR challenge of 2026: AJ, accuracy on visible points (ATA, here delta_avg), OA. Thresholds in pixels of the
/// original picture, strictly below; without the first labelled frame; pooled over all clips.
inline constexpr Thresholds stir_2026_pixels{2, 4, 8, 16, 32};
JaccardSums stir_2026_sums(const Clip &clip);

/// The STIR challenges of 2024 and 2025 have no identities: the distance from each tracked start point to the *nearest*
/// end point. Shares within these thresholds, and their mean; pooled over all clips.
inline constexpr Thresholds stir_2024_pixels{4, 8, 16, 32, 64};
struct Stir2024Score {
  double delta_avg = unknown;
  Thresholds within{unknown, unknown, unknown, unknown, unknown};
};
/// Distances of `points` to the nearest of clip.ends; infinite for infinite points. Nothing without ends.
std::vector<double> end_distances(const Clip &clip, std::span<const cv::Point2d> points);
Stir2024Score stir_2024_score(std::span<const double> distances);

}  // namespace csd::score
