// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include "patch/patch_plane.h"

namespace csd::test {

/// Calls visit(x, y) for each sample of a patch, by rows.
template <class Visit>
void for_each_offset(Visit visit) {
  for (int y = -PatchPlane::radius; y <= PatchPlane::radius; ++y)
    for (int x = -PatchPlane::radius; x <= PatchPlane::radius; ++x) visit(x, y);
}

}  // namespace csd::test
