// SPDX-License-Identifier: LGPL-2.1-or-later
#include "programs/truth_table.h"

#include <algorithm>

namespace csd::programs {

void TruthTable::add(std::uint64_t frame, std::int64_t pts, FeatureId id, const score::TruthPoint &point,
                     std::size_t line) {
  Frame &labels = frames_.try_emplace(frame, Frame{pts, line, {}}).first->second;
  if (!labels.points.emplace(id, point).second)
    throw score::InputError(file_, line,
                            "feature " + std::to_string(id) + " a second time in frame " + std::to_string(frame));
}

void TruthTable::size(int width, int height, std::size_t line) {
  if (width_ != 0 && (width != width_ || height != height_))
    throw score::InputError(file_, line, "the picture's size changes");
  width_ = width;
  height_ = height;
}

score::Truth TruthTable::take() {
  score::Truth truth;
  truth.file = file_;
  truth.width = width_;
  truth.height = height_;
  for (const auto &[number, frame] : frames_)
    for (const auto &[id, point] : frame.points) truth.ids.push_back(id);
  std::sort(truth.ids.begin(), truth.ids.end());
  truth.ids.erase(std::unique(truth.ids.begin(), truth.ids.end()), truth.ids.end());
  for (const auto &[number, frame] : frames_) {
    score::TruthFrame labels{number, frame.pts, frame.line, std::vector<score::TruthPoint>(truth.ids.size())};
    bool labelled = false;
    for (const auto &[id, point] : frame.points) {
      const auto column = std::lower_bound(truth.ids.begin(), truth.ids.end(), id) - truth.ids.begin();
      labels.points[static_cast<std::size_t>(column)] = point;
      labelled = labelled || point.presence != score::Presence::unlabelled;
    }
    if (labelled) truth.frames.push_back(std::move(labels));
  }
  if (truth.frames.empty()) throw score::InputError(file_, 0, "labels nothing");
  return truth;
}

}  // namespace csd::programs
