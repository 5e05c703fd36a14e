// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include "track/align.h"

namespace csd {

/// How much of the feature's very place fits, 0…1: Σ robust weights / Σ anchor weights over the patch's inner 7 × 7
/// samples. A tool's edge or a highlight that has come to the point itself shows here while most of the patch still
/// fits. Alignment::inliers where the anchor knows nothing of that place.
/// @param noise the residual's usual deviation, grey levels of the anchor: by that of this very frame a covered point
/// would excuse itself. @param seen a usable alignment of `anchor`
double centre_inliers(const Pyramid &pyramid, const GlareWeights &weights, const AnchorLevel &anchor, int level,
                      const Alignment &seen, double noise);

}  // namespace csd
