// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <string_view>

#include "csd/tuning.h"

namespace csd {

/// All that speaks for a feature being visible where it was aligned.
struct Evidence {
  double zncc_fine = 0, zncc_coarse = 0;  ///< Alignment::zncc of the two levels
  double unmasked = 0;                    ///< of the fine level
  double centre = 0;                      ///< centre_inliers()
  double gain = 1;                        ///< contrast, of the anchor's
  double noise = 0;                       ///< residual, grey levels of the anchor
  double brightness_change = 0;           ///< grey levels, against its usual one and the supporting points' change
  double contrast = 0;                    ///< standard deviation of the anchor, grey levels
  std::optional<double> likeness;         ///< Likeness::far(); none while the anchor is learnt
  /// How far it lies from where the neighbours put it, in its own expected error, times how much its anchor looks like
  /// the tissue in that direction: what has no look-alike there needs nobody's word.
  double disagreement = 0;
};

/// Probability that the feature is visible and within 5 px (at 576 lines or less) of where it was aligned: a logistic
/// regression. It is calibrated: of the reports with .8, four in five are right.
double visibility(const Evidence &evidence, const Tuning &tuning);

/// What the regression weighs; the weights are Tuning's, and tests/bench/fit finds them.
inline constexpr std::size_t visibility_terms = 13;
std::array<double, visibility_terms> visibility_values(const Evidence &evidence, const Tuning &tuning);
std::string_view visibility_name(std::size_t term);

}  // namespace csd
