// SPDX-License-Identifier: LGPL-2.1-or-later
#include "score/recovery.h"

namespace csd::score {

std::vector<Recovery> recoveries(const Clip &clip, double tau) {
  std::vector<Recovery> all;
  for (std::size_t f = 0; f < clip.ids.size(); ++f) {
    bool seen = false, hidden = false, waiting = false;
    Moment back;
    for (std::size_t t = 0; t < clip.moments.size(); ++t) {
      const Sample &sample = clip.at(f, t);
      if (!sample.labelled()) continue;
      if (!sample.visible()) {
        hidden = seen;
        continue;
      }
      const Moment &now = clip.moments[t];
      if (hidden) {
        all.push_back({});
        back = now;
        waiting = true;
      }
      seen = true;
      hidden = false;
      if (waiting && sample.claimed && sample.distance() <= tau) {
        const bool timed = back.pts != no_time && now.pts != no_time;
        all.back() = {true, now.frame - back.frame, timed ? now.pts - back.pts : no_time};
        waiting = false;
      }
    }
  }
  return all;
}

}  // namespace csd::score
