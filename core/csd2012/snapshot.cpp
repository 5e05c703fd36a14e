// SPDX-License-Identifier: LGPL-2.1-or-later
#include "csd2012/snapshot.h"

#include <algorithm>

#include "csd2012/smoothed.h"
#include "image/convert.h"

namespace csd {

const Snapshot::Channel &Snapshot::in(const ColourSpace &space, double sigma, int half) const {
  Made *made = nullptr;
  {
    const std::lock_guard lock(mutex_);
    const auto at = std::find_if(made_.begin(), made_.end(), [&](const Made &m) { return m.space == space; });
    made = at != made_.end() ? &*at : &made_.emplace_back(space);
  }
  const std::lock_guard lock(made->making);
  if (made->channel.smoothed.empty()) {
    Channel made_now;
    to_space(bgr, space, made_now.raw);
    const int border = half + csd2012::smoothing_margin(sigma);
    cv::Mat grown;
    cv::copyMakeBorder(made_now.raw, grown, border, border, border, border, cv::BORDER_REPLICATE);
    csd2012::smooth(grown, sigma, made_now.smoothed);
    made->channel = made_now;
  }
  return made->channel;
}

}  // namespace csd
