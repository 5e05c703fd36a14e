// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "score/clip.h"

namespace csd::score {

inline constexpr std::size_t jaccard_thresholds = 5;
using Thresholds = std::array<double, jaccard_thresholds>;

/// The sums behind TAP-Vid's and STIR's measures. They are additive over features and clips.
struct JaccardSums {
  std::uint64_t evaluated = 0;  ///< samples
  std::uint64_t agreed = 0;     ///< claimed ⇔ visible
  std::uint64_t visible = 0;
  std::array<std::uint64_t, jaccard_thresholds> within{};          ///< visible, position closer than the threshold
  std::array<std::uint64_t, jaccard_thresholds> true_positive{};   ///< … and claimed
  std::array<std::uint64_t, jaccard_thresholds> false_positive{};  ///< claimed, but hidden or not within

  void add(const JaccardSums &other, std::uint64_t times = 1);
  void add(const Sample &sample, double distance, const Thresholds &thresholds);
};

struct JaccardScore {
  double delta_avg = unknown;  ///< mean of `within`
  double aj = unknown;         ///< mean of `jaccard`
  double oa = unknown;         ///< agreed / evaluated
  Thresholds within{};         ///< share of the visible
  Thresholds jaccard{};        ///< TP / (TP + FP + FN), with TP + FN = visible
};
JaccardScore jaccard_score(const JaccardSums &sums);

}  // namespace csd::score
