// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include "score/clip.h"

namespace csd::score {

struct AlignOptions {
  bool by_frame = false;       ///< match by frame number even if the truth has pts
  std::vector<FeatureId> ids;  ///< ascending; the ids to score. Empty: all
  int width = 0, height = 0;   ///< of the picture, if neither file has it; 0: unknown
};

/// Aligns reports with the truth. Frames match if their pts differ by less than half the shortest step between frames
/// of the tracks or, if the truth has no pts, if their numbers are equal. Adds caveats for the reader of the score to
/// `notes`. Throws InputError if the two don't belong together: another picture size or none, a labelled frame missing
/// from the tracks, a feature that they never mention.
Clip align(const Truth &truth, const Recording &tracks, const AlignOptions &options, std::vector<std::string> &notes);

}  // namespace csd::score
