// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include "score/types.h"

namespace csd::programs {

/// A folder of STIR (seqNN), or its `segmentation`: icgstartseg.png and icgendseg.png show the tattoos in the first and
/// the last frame. A point is the middle of a contour's bounding box, as STIR's own loader takes it; nobody knows which
/// end point belongs to which start point. Throws score::InputError.
score::Truth read_stir(const std::string &folder);

}  // namespace csd::programs
