// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "score/clip.h"

namespace csd::score {

/// The paper's counts in a frame (§3): a match is correct if it is at most τ from the truth.
struct Counts {
  std::uint64_t correct = 0;
  std::uint64_t wrong = 0;      ///< the feature is visible, the claim too far off
  std::uint64_t missed = 0;     ///< the feature is visible, nothing is claimed
  std::uint64_t on_hidden = 0;  ///< a position is claimed for a hidden feature, or one outside
  std::uint64_t quiet = 0;      ///< hidden or outside, and nothing is claimed

  Counts &operator+=(const Counts &other);
  double sensitivity() const;     ///< correct / visible; unknown if nothing is visible
  double k() const;               ///< 1 − precision: (wrong + on_hidden) / claimed; unknown if nothing is claimed
  double k_visible() const;       ///< the same without on_hidden
  double hidden_claimed() const;  ///< on_hidden / hidden
};

/// For each sample of a clip, whether it is visible, claimed, correct: 0 or 1, features × moments.
struct Outcomes {
  Outcomes(const Clip &clip, double tau);
  std::size_t features, moments;
  std::vector<std::uint8_t> visible, claimed, correct;
  std::vector<std::uint8_t> labelled;
};

/// Counts of each labelled frame.
std::vector<Counts> count_frames(const Outcomes &outcomes);

/// Sensitivity and K of a clip: means over its frames. Excludes frames without visible features from sensitivity, and
/// frames without claims from K.
struct PaperScore {
  double sensitivity = unknown, k = unknown, k_visible = unknown;
};
PaperScore paper_score(std::span<const Counts> frames);

/// The same with each feature counted `weights` times; the bootstrap calls it ten thousand times. k_visible stays
/// unknown.
PaperScore paper_score(const Outcomes &outcomes, std::span<const std::uint32_t> weights);

/// The curve's thresholds, in pixels at 576 lines or less. tolerance() scales them.
inline constexpr double curve_pixels[] = {1, 2, 4, 5, 8, 16, 32};
inline constexpr double headline_pixels = 5;

}  // namespace csd::score
