// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include "score/types.h"

namespace csd::programs {

/// Adds a note if features are missing from the tracks. csdtrackenc lists each feature in every frame from its first to
/// the one in which it has `ended`, so a gap, or an early end, means that a part of the file was lost. Frames written
/// without metadata don't count.
void note_absent(const score::Recording &tracks, std::vector<std::string> &notes);

}  // namespace csd::programs
