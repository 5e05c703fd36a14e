// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

#include "score/jaccard.h"
#include "score/sensitivity.h"
#include "score/survival.h"

namespace csd::score {

/// The scores that have confidence intervals and are compared: means over clips.
enum class Headline : std::uint8_t { sensitivity, k, delta_avg, aj, oa, survival };
inline constexpr std::size_t headline_count = 6;
using Headlines = std::array<double, headline_count>;
/// "sensitivity", "k", "delta_avg", …: as in the JSON.
std::string_view headline_name(std::size_t headline);

/// The data for a clip's headline scores, by feature.
struct ClipStatistics {
  explicit ClipStatistics(const Clip &clip);
  Outcomes outcomes;
  std::vector<JaccardSums> tap_vid;
  std::vector<SurvivalSums> survival;
};

/// The headline scores of the given clips.
Headlines headlines(std::span<const ClipStatistics> clips);

/// The headline scores of `resamples` draws. Each draws as many clips as there are, and as many features from each as
/// it has, with replacement. The draws depend only on `seed` and the numbers of clips and features, so those of two
/// trackers on the same truth are paired.
std::vector<Headlines> bootstrap(std::span<const ClipStatistics> clips, unsigned resamples, std::uint64_t seed);

/// 95 % by percentiles. Unknown for a single clip with a single feature: nothing varies.
struct Interval {
  double low = unknown, high = unknown;
};
Interval interval(std::span<const Headlines> draws, std::size_t headline);

/// a − b on the same truth. `p` is two-sided: twice the smaller share of draws with a difference ≤ 0 or ≥ 0, and at
/// least 2^(1 − features), the least of an exact paired test of so many features.
struct Comparison {
  double difference = unknown;
  Interval confidence;
  double p = unknown;
};
Comparison compare(double a, std::span<const Headlines> draws_a, double b, std::span<const Headlines> draws_b,
                   std::size_t headline, std::size_t features);

}  // namespace csd::score
