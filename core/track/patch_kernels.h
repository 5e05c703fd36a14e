// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <opencv2/core.hpp>

#include <array>

#include "track/anchor.h"
#include "track/patch_map.h"

namespace csd {

/// The unknowns of one Gauss–Newton step, in the order of elimination: gain, bias, then the shape (x·Tx, y·Tx, x·Ty,
/// y·Ty with x, y = v/10), then the position, in samples (Tx, Ty).
inline constexpr int unknowns = 8, first_shape = 2, first_position = 6;

/// The linear system of one step in the anchor's grey levels: Σ w J Jᵀ (its upper triangle) and Σ w J r.
struct NormalEquations {
  std::array<std::array<double, unknowns>, unknowns> matrix{};
  std::array<double, unknowns> gradient{};
};

/// How a sampled patch fits its anchor: frame = gain·anchor + bias.
struct PatchFit {
  double gain = 1, bias = 0;
  double noise = 0;    ///< 1.48 · median |r| where there is weight
  double weight = 0;   ///< Σ m, the product of both weights
  double inliers = 0;  ///< Σ robust · m
  int counted = 0;     ///< pixels of which the noise is known: m > .25
  NormalEquations equations;
};

/// Weighted moments of frame and anchor.
struct PatchMoments {
  double weight = 0, frame_variance = 0, anchor_variance = 0, covariance = 0;  ///< grey levels²
};

namespace scalar {
/// 21 × 21 bilinear samples of `level` (CV_16UC1, 1/256 of a grey level) and of `weights` (CV_8UC1 of the same size, or
/// empty: all count). Beyond the outermost pixels' centres the border is repeated and the weight is 0.
void sample_patch(const cv::Mat &level, const cv::Mat &weights, const PatchMap &map, PatchSample &out);
/// Gain and bias by least squares under `robust`, residuals, their scale, new robust weights, normal equations.
/// `robust`: in: weights of the iteration before (1 where unknown); out: those of these residuals.
void fit_patch(const AnchorLevel &anchor, const PatchSample &sample, PatchPlane &robust, PatchFit &fit);
PatchMoments patch_moments(const AnchorLevel &anchor, const PatchSample &sample);
}  // namespace scalar

}  // namespace csd
