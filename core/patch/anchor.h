// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <opencv2/core.hpp>

#include <array>
#include <memory>

#include "content/glare_weights.h"
#include "image/pyramid.h"
#include "patch/affine_state.h"
#include "patch/patch_plane.h"

namespace csd {

/// A feature's appearance at one resolution: a patch of 21 × 21 samples at offsets 2^level·v with v in [−10, 10]², its
/// gradients in v, and its weights. Immutable once built.
struct AnchorLevel {
  PatchPlane patch;       ///< grey levels, weighted mean removed
  PatchPlane gradient_x;  ///< ∂patch/∂v, central differences within the patch (one-sided on its edge)
  PatchPlane gradient_y;
  PatchPlane weight;                         ///< 0…1; 0: may be a highlight; outside the picture, or padding
  PatchPlane shown;                          ///< 0…1; 0: outside the picture, forbidden, or padding
  double tissue_share = 0, shown_share = 0;  ///< means of `weight` and `shown`, set by make_anchor_level
};

/// With a smaller share of tissue in a patch, what may be highlights are its texture.
inline constexpr double min_tissue = 0.1;

/// A feature's appearance at several resolutions: levels 0, 1 and 2 from its start; −1 and −2, finer than its first
/// frame, once a zoom resolves them.
class Anchor {
 public:
  static constexpr int finest = -2, coarsest = 2;
  bool has(int level) const;                       ///< false also beyond finest…coarsest
  const AnchorLevel &level(int level) const;       ///< has(level)
  void set(int level, const AnchorLevel &anchor);  ///< finest ≤ level ≤ coarsest
  /// The finest existing level that the picture resolves at `zoom` (√det shape, relative to the feature's start):
  /// zoom·2^level ≥ .75; if there is none, the coarsest. At least one level must exist.
  int fine_level(double zoom) const;

 private:
  std::array<std::unique_ptr<AnchorLevel>, coarsest - finest + 1> levels_;
};

/// A feature's patch in one frame at one level.
struct PatchSample {
  PatchPlane value;   ///< grey levels; outside the picture its border is replicated
  PatchPlane weight;  ///< 0…1: GlareWeights / 255, and 0 outside the picture
  double inside = 0;  ///< share of the samples inside the picture
};

/// Samples the patch at `state` bilinearly, at the pyramid level that matches its size in the picture:
/// clamp(round(log2(scale·2^level)), 0, 4). If `weights` is empty, every pixel counts.
PatchSample sample(const Pyramid &pyramid, const GlareWeights &weights, const AffineState &state, int level);

AnchorLevel make_anchor_level(const PatchSample &sample);

/// Replaces a sample's weights by those of its comparison with an anchor: how far they agree on what each pixel shows.
/// What is bright in both is texture. What is bright in one of them is a highlight that came or went.
/// @param tissue becomes the part of that weight where both show tissue
void weigh_agreement(const AnchorLevel &anchor, PatchPlane &weight, PatchPlane &tissue);

}  // namespace csd
