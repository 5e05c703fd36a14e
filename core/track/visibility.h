// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

namespace csd {

/// All that speaks for a feature being visible where it was aligned.
struct Evidence {
  double zncc_fine = 0, zncc_coarse = 0;  ///< Alignment::zncc of the two levels
  double inliers = 0, unmasked = 0;       ///< of the fine level
  double centre = 0;                      ///< centre_inliers()
  double gain = 1;                        ///< contrast, of the anchor's
  double noise = 0;                       ///< residual, grey levels of the anchor
  double disagreement = 0;                ///< from where the neighbours put it, in its own expected error
  bool seen_before = false;               ///< it was visible in the last frame
  double gain_change = 0;                 ///< |ln gain| against its own usual one and its neighbours' common change
  double brightness_change = 0;           ///< grey levels, against its usual one and the supporting points' change
};

/// Probability that the feature is visible and within 5 px (at 576 lines or less) of where it was aligned: a logistic
/// regression. It is calibrated: of the reports with .8, four in five are right.
double visibility(const Evidence &evidence);

}  // namespace csd
