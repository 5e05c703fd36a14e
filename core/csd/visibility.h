// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <string_view>

#include "csd/tuning.h"

namespace csd {

/// The evidence that a feature is visible at its aligned position.
struct Evidence {
  double zncc_fine = 0, zncc_coarse = 0;  ///< Alignment::zncc of the two levels
  double unmasked = 0;                    ///< of the fine level
  double centre = 0;                      ///< centre_inliers()
  double gain = 1;                        ///< contrast relative to the anchor's
  double noise = 0;                       ///< residual, grey levels of the anchor
  double brightness_change = 0;           ///< grey levels, relative to its usual one and the supporting points' change
  double contrast = 0;                    ///< standard deviation of the anchor, grey levels
  std::optional<double> self_similarity;  ///< SelfSimilarity::far(); empty while the anchor is learned
  /// Distance from the predicted position, in units of its expected error, times the anchor's self-similarity in that
  /// direction: a patch without similar places there needs no support from its neighbours.
  double disagreement = 0;
};

/// Probability that the feature is visible and within 5 px (at 576 lines or less) of its aligned position, by a
/// calibrated logistic regression: of the reports with .8, four in five are correct.
double visibility(const Evidence &evidence, const Tuning &tuning);

/// The values that the regression weighs. The weights are in Tuning; tests/bench/fit fits them.
inline constexpr std::size_t visibility_terms = 13;
std::array<double, visibility_terms> visibility_values(const Evidence &evidence, const Tuning &tuning);
std::string_view visibility_name(std::size_t term);

}  // namespace csd
