// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <optional>

#include "patch/anchor.h"

namespace csd {

/// How much of the feature's very place fits, 0…1: Σ robust weights / Σ anchor weights over the patch's inner 7 × 7
/// samples. A tool's edge or a highlight that has come to the point itself shows here while most of the patch still
/// fits. Nothing where the anchor knows nothing of that place.
/// @param value, weight what the picture has at the anchor's samples, and what each counts
/// @param gain, bias value = gain·anchor + bias
/// @param noise the residual's usual deviation, grey levels of the anchor: by that of this very frame a covered point
/// would excuse itself
std::optional<double> centre_inliers(const AnchorLevel &anchor, const PatchPlane &value, const PatchPlane &weight,
                                     double gain, double bias, double noise);

}  // namespace csd
