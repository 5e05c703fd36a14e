// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include "score/clip.h"

namespace csd::score {

/// Hand-made samples, named by the truth and the tracker's claim.
inline Sample seen(double dx, double dy = 0) {
  return {Presence::visible, true, true, dx, dy, 1};
}
/// Visible, not claimed; the last report is off by dx,dy.
inline Sample missed(double dx, double dy = 0) {
  return {Presence::visible, true, false, dx, dy, 0};
}
inline Sample quiet(Presence presence = Presence::hidden) {
  return {presence, true, false, 0, 0, 0};
}
inline Sample ghost(Presence presence = Presence::hidden) {
  return {presence, true, true, 0, 0, 1};
}
inline Sample unlabelled() {
  return {Presence::unlabelled, true, true, 0, 0, 1};
}

/// A clip of features with equally many samples; frames 0, 1, 2… at 25 a second.
inline Clip clip_of(int width, int height, const std::vector<std::vector<Sample>> &features) {
  Clip clip;
  clip.width = width;
  clip.height = height;
  for (std::size_t t = 0; t < features.front().size(); ++t)
    clip.moments.push_back({t, static_cast<std::int64_t>(t) * 40000000});
  for (const auto &feature : features) {
    clip.ids.push_back(static_cast<FeatureId>(clip.ids.size()));
    clip.samples.insert(clip.samples.end(), feature.begin(), feature.end());
  }
  return clip;
}

}  // namespace csd::score
