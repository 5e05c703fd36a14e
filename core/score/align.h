// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include "score/clip.h"

namespace csd::score {

struct AlignOptions {
  bool by_frame = false;       ///< match by frame number even where the truth has pts
  std::vector<FeatureId> ids;  ///< ascending; score these only. Empty: all
  int width = 0, height = 0;   ///< of the picture, where neither file says; 0: unknown
};

/// Lays what was reported beside the truth. A frame of the truth and one of the tracks are the same if their pts differ
/// by less than half the shortest step between frames of the tracks; where the truth has no pts, if their numbers are
/// equal. Adds to `notes` what the reader of the score must know. Throws InputError if the two don't belong together:
/// another picture size or none, a labelled frame that the tracks lack, a feature that they never mention.
Clip align(const Truth &truth, const Recording &tracks, const AlignOptions &options, std::vector<std::string> &notes);

}  // namespace csd::score
