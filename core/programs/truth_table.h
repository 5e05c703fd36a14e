// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <map>

#include "score/types.h"

namespace csd::programs {

/// Collects labels in any order.
class TruthTable {
 public:
  explicit TruthTable(std::string file) : file_(std::move(file)) {}

  /// Adds a label of a frame. Throws score::InputError if the frame already has one of this feature.
  void add(std::uint64_t frame, std::int64_t pts, FeatureId id, const score::TruthPoint &point, std::size_t line);
  /// Sets a frame's picture size, if known. Throws score::InputError if it changes.
  void size(int width, int height, std::size_t line);

  /// The whole truth, without unlabelled frames. Throws score::InputError if nothing is left.
  score::Truth take();

 private:
  struct Frame {
    std::int64_t pts;
    std::size_t line;
    std::map<FeatureId, score::TruthPoint> points;
  };
  std::string file_;
  int width_ = 0, height_ = 0;
  std::map<std::uint64_t, Frame> frames_;
};

}  // namespace csd::programs
