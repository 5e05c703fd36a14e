// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <array>
#include <cstddef>

#include "patch/anchor.h"
#include "patch/patch_plane.h"

namespace csd {

/// The unknowns of one Gauss–Newton step, in the order of elimination: gain, bias, then the shape (x·Tx, y·Tx, x·Ty,
/// y·Ty with x, y = v/10), then the position, in samples (Tx, Ty).
inline constexpr std::size_t unknowns = 8, first_shape = 2, first_position = 6;

/// The fit of a sampled patch to its anchor, frame = gain·anchor + bias in the anchor's grey levels, and the linear
/// system of the next step.
struct PatchFit {
  double gain = 1, bias = 0;
  double noise = 0;                         ///< 1.48 · median |r| over the weighted pixels, |r| clamped to 256
  double weight = 0;                        ///< Σ m
  double inliers = 0;                       ///< Σ robust · m
  int counted = 0;                          ///< pixels that enter the noise: m > .25
  std::array<double, unknowns> gradient{};  ///< Σ w J r, w = robust · m
  /// Σ w J Jᵀ, upper triangle. It only steers the steps and is recomputed when the weights have changed by a tenth.
  std::array<std::array<double, unknowns>, unknowns> matrix{};
  double drift = -1;  ///< Σ |change of w| since the matrix was computed; negative: not computed yet
};

/// Least weight of a pixel whose residual enters the noise; least gain; change of the weights that recomputes the
/// matrix.
inline constexpr float counted_weight = .25F, smallest_gain = .08F, largest_drift = .1F;
/// Clamp of |r| for the noise, grey levels of the anchor: 15 bits in 1/128.
inline constexpr float largest_residual = 32767 / 128.F;
/// Weighted moments of frame and anchor.
struct PatchMoments {
  double weight = 0, frame_variance = 0, anchor_variance = 0, covariance = 0;  ///< grey levels²
};

/// ZNCC of picture and anchor, by all samples on which they agree. By those alone that show tissue in both, if these
/// are a tenth of the patch with a deviation of 3 grey levels and it is less: a highlight that stands still fits
/// whatever slides under it, among faint tissue with .97 if it is a tenth of the patch.
double correlation(const PatchMoments &all, const PatchMoments &of_tissue);

/// Computes gain and bias by least squares under `robust`, then residuals, their scale, new robust weights, and the
/// linear system. `weight`: m, the product of the anchor's and the frame's weight. `robust`: in: weights of the
/// previous iteration (1 at first); out: new weights. `fit.matrix` and `fit.drift` persist between iterations. On the
/// machine's best SIMD target.
void fit_patch(const AnchorLevel &anchor, const PatchPlane &value, const PatchPlane &weight, PatchPlane &robust,
               PatchFit &fit);
PatchMoments patch_moments(const AnchorLevel &anchor, const PatchPlane &value, const PatchPlane &weight);

/// The same without SIMD.
void fit_patch_scalar(const AnchorLevel &anchor, const PatchPlane &value, const PatchPlane &weight, PatchPlane &robust,
                      PatchFit &fit);
PatchMoments patch_moments_scalar(const AnchorLevel &anchor, const PatchPlane &value, const PatchPlane &weight);

}  // namespace csd
