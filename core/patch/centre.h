// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <optional>

#include "patch/anchor.h"

namespace csd {

/// Inlier share of the patch's centre, 0…1: Σ robust weights / Σ weights over the inner 7 × 7 samples. It drops when a
/// tool's edge or a highlight reaches the point while most of the patch still fits: what only the picture masks counts
/// as known. Empty if the anchor is masked there.
/// @param value, weight the picture's values at the anchor's samples, and weigh_agreement()
/// @param gain, bias value = gain·anchor + bias
/// @param noise the residual's usual deviation, grey levels of the anchor. Measured in the same frame, it would grow
/// with an occlusion and hide it.
std::optional<double> centre_inliers(const AnchorLevel &anchor, const PatchPlane &value, const PatchPlane &weight,
                                     double gain, double bias, double noise);

}  // namespace csd
