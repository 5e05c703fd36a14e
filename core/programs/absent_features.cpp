// SPDX-License-Identifier: LGPL-2.1-or-later
#include "programs/absent_features.h"

#include <algorithm>
#include <set>

namespace csd::programs {
namespace {

bool by_id(const Feature &a, const Feature &b) {
  return a.id < b.id;
}

}  // namespace

void note_absent(const score::Recording &tracks, std::vector<std::string> &notes) {
  std::set<FeatureId> living, gone;
  std::size_t frames = 0;
  const score::TrackFrame *first = nullptr;
  const score::TrackFrame *before = nullptr;
  for (const score::TrackFrame &frame : tracks.frames) {
    if (!frame.numbered) continue;
    // csdtrack forgets all features then.
    if (before && (before->width != frame.width || before->height != frame.height)) living.clear();
    before = &frame;
    bool whole = true;
    for (const FeatureId id : living)
      if (!std::binary_search(frame.features.begin(), frame.features.end(), Feature{id, 0, 0, {}, 0, false}, by_id)) {
        gone.insert(id);
        whole = false;
      }
    if (!whole && !first) first = &frame;
    frames += !whole;
    for (const Feature &feature : frame.features) {
      if (feature.state == FeatureState::ended)
        living.erase(feature.id);
      else
        living.insert(feature.id);
    }
  }
  if (!first) return;
  notes.push_back(tracks.file + ":" + std::to_string(first->line) + ": from frame " + std::to_string(first->frame) +
                  " on, " + std::to_string(gone.size()) +
                  (gone.size() == 1 ? " feature is absent" : " features are absent") + " that had not ended, in " +
                  std::to_string(frames) + (frames == 1 ? " frame" : " frames") +
                  ", counted as not tracked: is the file whole?");
}

}  // namespace csd::programs
