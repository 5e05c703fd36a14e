// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include "score/types.h"

namespace csd::programs {

/// Adds a note if the tracks lack what must be there: csdtrackenc lists each feature in every frame from its first to
/// the one in which it has `ended`, so a feature that is absent in between, or from the last frame on, was lost with a
/// part of the file. Frames that were written without metadata say nothing of features.
void note_absent(const score::Recording &tracks, std::vector<std::string> &notes);

}  // namespace csd::programs
