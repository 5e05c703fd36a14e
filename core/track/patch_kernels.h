// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <opencv2/core.hpp>

#include <array>
#include <cstdint>

#include "track/anchor.h"
#include "track/patch_map.h"

namespace csd {

/// The part of a pyramid level in which a patch moves: copied once for a pass, with the border repeated, so that
/// sampling has no edge to mind. An entry holds a pixel and the one below it: 64 bits from any entry on are the four
/// pixels that a sample lies between.
struct PatchTile {
  static constexpr int side = 64;
  int x0 = 0, y0 = 0;         ///< the first pixel, in the level
  int width = 0, height = 0;  ///< of the filled part; 0: none
  int right = 0, bottom = 0;  ///< the last pixel of the picture, in the tile
  bool plain = false;         ///< all of it lies in the picture and has full weight
  alignas(64) std::uint32_t pixels[side * side];
  alignas(64) std::uint32_t weights[side * side];  ///< unless plain; 1/255
};

/// Fills `tile` with what samples of `map` need, and a margin for steps to come; does nothing if it has that already.
/// False if they need more than the tile can hold. `level` and `weights` as in scalar::sample_patch.
bool prepare_tile(const cv::Mat &level, const cv::Mat &weights, const PatchMap &map, PatchTile &tile);

/// The unknowns of one Gauss–Newton step, in the order of elimination: gain, bias, then the shape (x·Tx, y·Tx, x·Ty,
/// y·Ty with x, y = v/10), then the position, in samples (Tx, Ty).
inline constexpr std::size_t unknowns = 8, first_shape = 2, first_position = 6;

/// How a sampled patch fits its anchor: frame = gain·anchor + bias, in the anchor's grey levels, and the linear system
/// of the next step.
struct PatchFit {
  double gain = 1, bias = 0;
  double noise = 0;                         ///< 1.48 · median |r| where there is weight
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
/// How far beyond the outermost pixels' centres a sample still counts as inside: a rounding error, not a pixel.
inline constexpr double inside_tolerance = 1e-3;

/// Weighted moments of frame and anchor.
struct PatchMoments {
  double weight = 0, frame_variance = 0, anchor_variance = 0, covariance = 0;  ///< grey levels²
};

/// Kernels, on the best SIMD target of the machine.
///
/// 21 × 21 bilinear samples of a prepared tile: grey levels; weights, 0 outside the picture (tile.plain: not written,
/// all 1). Gives the share of the samples that lie in the picture.
double sample_tile(const PatchTile &tile, const PatchMap &map, PatchPlane &value, PatchPlane &weight);
/// Gain and bias by least squares under `robust`, residuals, their scale, new robust weights, the linear system.
/// `weight`: m, the product of the anchor's weight and the frame's. `robust`: in: weights of the iteration before (1
/// where unknown); out: those of these residuals. `fit.matrix` and `fit.drift` go on from one iteration to the next.
void fit_patch(const AnchorLevel &anchor, const PatchPlane &value, const PatchPlane &weight, PatchPlane &robust,
               PatchFit &fit);
PatchMoments patch_moments(const AnchorLevel &anchor, const PatchPlane &value, const PatchPlane &weight);
/// out = a · b
void multiply(const PatchPlane &a, const PatchPlane &b, PatchPlane &out);

/// Their plain twins.
namespace scalar {
/// The same straight from `level` (CV_16UC1, 1/256 of a grey level) and `weights` (CV_8UC1 of the same size, or empty:
/// all count). Beyond the outermost pixels' centres the border is repeated.
double sample_patch(const cv::Mat &level, const cv::Mat &weights, const PatchMap &map, PatchPlane &value,
                    PatchPlane &weight);
void fit_patch(const AnchorLevel &anchor, const PatchPlane &value, const PatchPlane &weight, PatchPlane &robust,
               PatchFit &fit);
PatchMoments patch_moments(const AnchorLevel &anchor, const PatchPlane &value, const PatchPlane &weight);
}  // namespace scalar

}  // namespace csd
