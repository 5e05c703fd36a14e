// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include "patch/anchor.h"

namespace csd {

/// The prior of an alignment.
struct AlignPrior {
  /// Information about the position, 1/px² (working pixels): zero if unknown.
  cv::Matx22d position = cv::Matx22d::zeros();
  /// Standard deviation of each element of shape₀⁻¹·shape − 1.
  double shape = .03;
  double noise = 0;  ///< usual standard deviation of the residual, grey levels of the picture; 0: unknown
};

/// Convergence threshold: an alignment ends when the expected sum of the remaining steps is below this, samples.
inline constexpr double fine_precision = .008, support_precision = .06, coarse_precision = .2;

enum class AlignModel { similarity, affine };  ///< 4 or 6 degrees of freedom

/// The result of an alignment.
struct Alignment {
  AffineState state;
  bool usable = false;        ///< false: less than 30 % of the patch is in the picture, or it has no texture
  double zncc = 0;            ///< weighted (not robustly) zero-mean normalised cross-correlation, −1…1
  double inliers = 0;         ///< Σ robust weights / Σ weights, 0…1
  double centre = 0;          ///< the same for the patch's centre: centre_inliers(); `inliers` if that is unknown
  double unmasked = 0;        ///< share of the patch on which picture and anchor agree: weigh_agreement(), 0…1
  double gain = 1, bias = 0;  ///< frame = gain·anchor + bias, grey levels
  double noise = 0;           ///< robust standard deviation of the residual, grey levels of the anchor, ≤ 379 ("sig")
  cv::Matx22d information;    ///< about the position, from the data alone, 1/px² (working pixels)
  int iterations = 0;
};

/// Aligns one anchor level with a frame by inverse compositional Gauss–Newton, with gain and bias, robust weights, and
/// a Gaussian prior on shape and position about `start`.
Alignment align(const Pyramid &pyramid, const GlareWeights &weights, const AnchorLevel &anchor, int level,
                const AffineState &start, const AlignPrior &prior, AlignModel model, double precision = fine_precision);

/// The scalar reference for tests: positions agree within .01 of a sample, which is .01 px of the picture or of the
/// sampled pyramid level, whichever is larger. They differ most if one of them takes an extra step.
Alignment align_scalar(const Pyramid &pyramid, const GlareWeights &weights, const AnchorLevel &anchor, int level,
                       const AffineState &start, const AlignPrior &prior, AlignModel model,
                       double precision = fine_precision);

}  // namespace csd
