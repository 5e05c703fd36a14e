// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include "score/types.h"

namespace csd::programs {

/// A STIR folder (seqNN), or its `segmentation`: icgstartseg.png and icgendseg.png show the tattoos in the first and
/// the last frame. A point is the centre of a contour's bounding box, as in STIR's own loader; which end point belongs
/// to which start point is unknown. Throws score::InputError.
score::Truth read_stir(const std::string &folder);

}  // namespace csd::programs
