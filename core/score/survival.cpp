// SPDX-License-Identifier: LGPL-2.1-or-later
#include "score/survival.h"

namespace csd::score {

std::vector<SurvivalSums> survival_sums(const Clip &clip) {
  // A picture one pixel wide or high has no other positions on that axis.
  const double scale_x = 255.0 / std::max(1, clip.width - 1), scale_y = 255.0 / std::max(1, clip.height - 1);
  std::vector<SurvivalSums> sums(clip.ids.size());
  for (std::size_t f = 0; f < clip.ids.size(); ++f) {
    bool alive = true;
    for (std::size_t t = 0; t < clip.moments.size(); ++t) {
      const Sample &sample = clip.at(f, t);
      if (!sample.labelled()) continue;
      if (sample.visible() && std::hypot(scale_x * sample.dx, scale_y * sample.dy) > survival_pixels) alive = false;
      sums[f].alive += alive;
      ++sums[f].labelled;
    }
  }
  return sums;
}

}  // namespace csd::score
