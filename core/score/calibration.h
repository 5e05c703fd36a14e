// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <array>
#include <cstdint>

#include "score/clip.h"

namespace csd::score {

inline constexpr std::size_t confidence_bins = 10;

/// The reliability diagram: `confidence` should be the frequency with which the feature is visible and within τ of the
/// reported position. Includes every report on a labelled frame, even without a claim. Bin i is [i/10, (i+1)/10), the
/// last includes 1.
struct Reliability {
  struct Bin {
    std::uint64_t reports = 0, true_ones = 0;
    double confidence_sum = 0;
    double mean_confidence() const { return reports ? confidence_sum / static_cast<double>(reports) : unknown; }
    double frequency() const {
      return reports ? static_cast<double>(true_ones) / static_cast<double>(reports) : unknown;
    }
  };
  std::array<Bin, confidence_bins> bins{};

  void add(const Clip &clip, double tau);
  /// Expected calibration error: |mean confidence − frequency| of the bins, weighted by their reports.
  double ece() const;
};

}  // namespace csd::score
