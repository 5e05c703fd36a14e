// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include "score/jaccard.h"

namespace csd::score {

/// TAP-Vid (Doersch et al. 2022, `compute_tapvid_metrics`, query mode "first"): distances in a picture scaled to
/// 256×256, strictly below the threshold, in each feature's labelled frames after the one where it is first visible.
/// The caller takes the mean over videos.
inline constexpr Thresholds tap_vid_pixels{1, 2, 4, 8, 16};

/// One for each feature.
std::vector<JaccardSums> tap_vid_sums(const Clip &clip);

}  // namespace csd::score
