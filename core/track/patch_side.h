// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <algorithm>
#include <cmath>

#include "image/work_frame.h"
#include "track/settings.h"

namespace csd {

/// Odd side of the patch in working pixels, 5…255: the user's, converted from picture pixels, or the default for the
/// picture's height.
inline int patch_side(const Settings &settings, const WorkFrame &frame) {
  if (settings.patch_size == 0) return default_patch_size(frame.size().height);
  const int half = static_cast<int>(std::lround((settings.patch_size / frame.scale() - 1) / 2));
  return 2 * std::clamp(half, 2, 127) + 1;
}

}  // namespace csd
