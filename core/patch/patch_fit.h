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

/// How a sampled patch fits its anchor: frame = gain·anchor + bias, in the anchor's grey levels, and the linear system
/// of the next step.
struct PatchFit {
  double gain = 1, bias = 0;
  double noise = 0;                         ///< 1.48 · median |r| where there is weight, |r| no more than 256
  double weight = 0;                        ///< Σ m
  double inliers = 0;                       ///< Σ robust · m
  int counted = 0;                          ///< pixels of which the noise is known: m > .25
  std::array<double, unknowns> gradient{};  ///< Σ w J r, w = robust · m
  /// Σ w J Jᵀ, upper triangle. It only steers the steps, and is made anew when the weights have changed by a tenth.
  std::array<std::array<double, unknowns>, unknowns> matrix{};
  double drift = -1;  ///< Σ |change of w| since the matrix was made; negative: it never was
};

/// The weight from which a pixel's residual is taken for the noise; bound of the gain; change of the weights that makes
/// a new matrix.
inline constexpr float counted_weight = .25F, smallest_gain = .08F, largest_drift = .1F;
/// |r| that the noise knows, in grey levels of the anchor: 15 bits in 1/128.
inline constexpr float largest_residual = 32767 / 128.F;
/// Weighted moments of frame and anchor.
struct PatchMoments {
  double weight = 0, frame_variance = 0, anchor_variance = 0, covariance = 0;  ///< grey levels²
};

/// Gain and bias by least squares under `robust`, residuals, their scale, new robust weights, the linear system.
/// `weight`: m, the product of the anchor's weight and the frame's. `robust`: in: weights of the iteration before (1
/// where unknown); out: those of these residuals. `fit.matrix` and `fit.drift` go on from one iteration to the next.
/// On the best SIMD target of the machine.
void fit_patch(const AnchorLevel &anchor, const PatchPlane &value, const PatchPlane &weight, PatchPlane &robust,
               PatchFit &fit);
PatchMoments patch_moments(const AnchorLevel &anchor, const PatchPlane &value, const PatchPlane &weight);

/// Their plain twins.
void fit_patch_scalar(const AnchorLevel &anchor, const PatchPlane &value, const PatchPlane &weight, PatchPlane &robust,
                      PatchFit &fit);
PatchMoments patch_moments_scalar(const AnchorLevel &anchor, const PatchPlane &value, const PatchPlane &weight);

}  // namespace csd
