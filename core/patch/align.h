// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include "patch/anchor.h"

namespace csd {

/// What is believed before looking.
struct AlignPrior {
  /// Of the position's error, 1/px² (working pixels): zero where nothing is known.
  cv::Matx22d position = cv::Matx22d::zeros();
  /// Standard deviation of each element of shape₀⁻¹·shape − 1.
  double shape = .03;
  double noise = 0;  ///< usual standard deviation of the residual, grey levels of the picture; 0: unknown
};

/// How much of the way may be left when a pass ends, samples: it is what the steps to come would add.
inline constexpr double fine_precision = .008, support_precision = .06, coarse_precision = .2;

enum class AlignModel { similarity, affine };  ///< 4 or 6 degrees of freedom

/// How well a patch fits where it was put.
struct Alignment {
  AffineState state;
  bool usable = false;        ///< false: less than 30 % of the patch lies in the picture, or nothing to see in it
  double zncc = 0;            ///< weighted (not robustly) zero-mean normalised cross-correlation, −1…1
  double inliers = 0;         ///< Σ robust weights / Σ weights, 0…1
  double centre = 0;          ///< the same of the patch's very middle: centre_inliers(); inliers where that is unknown
  double unmasked = 0;        ///< share of the patch that has weight, 0…1
  double gain = 1, bias = 0;  ///< frame = gain·anchor + bias, grey levels
  double noise = 0;           ///< robust standard deviation of the residual, grey levels of the anchor, ≤ 379 ("sig")
  cv::Matx22d information;    ///< of the position, from the data alone, 1/px² (working pixels)
  int iterations = 0;
};

/// Aligns one anchor level with a frame: inverse compositional Gauss–Newton with gain and bias, robust weights, and a
/// Gaussian prior on shape and position about `start`.
Alignment align(const Pyramid &pyramid, const GlareWeights &weights, const AnchorLevel &anchor, int level,
                const AffineState &start, const AlignPrior &prior, AlignModel model, double precision = fine_precision);

/// The plain twin that tests compare with: the same position within .01 of a sample, which is .01 px of the picture or
/// of the pyramid level that the patch is sampled from, whichever is larger. They differ most where one of them takes a
/// step more.
Alignment align_scalar(const Pyramid &pyramid, const GlareWeights &weights, const AnchorLevel &anchor, int level,
                       const AffineState &start, const AlignPrior &prior, AlignModel model,
                       double precision = fine_precision);

}  // namespace csd
