// SPDX-License-Identifier: LGPL-2.1-or-later
#include "score/tap_vid.h"

namespace csd::score {

std::vector<JaccardSums> tap_vid_sums(const Clip &clip) {
  const double scale_x = 256.0 / clip.width, scale_y = 256.0 / clip.height;
  std::vector<JaccardSums> sums(clip.ids.size());
  for (std::size_t f = 0; f < clip.ids.size(); ++f) {
    bool begun = false;
    for (std::size_t t = 0; t < clip.moments.size(); ++t) {
      const Sample &sample = clip.at(f, t);
      if (begun && sample.labelled())
        sums[f].add(sample, std::hypot(scale_x * sample.dx, scale_y * sample.dy), tap_vid_pixels);
      begun = begun || sample.visible();
    }
  }
  return sums;
}

}  // namespace csd::score
