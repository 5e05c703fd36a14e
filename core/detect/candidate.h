// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <opencv2/core.hpp>

#include <algorithm>
#include <vector>

namespace csd {

/// A place that a detector proposes.
struct Candidate {
  cv::Point2d at;      ///< working pixels, centres at integers
  float strength = 0;  ///< the detector's own score; comparable only within one detector
};

/// Strongest first; equal strengths by row, then column, so that the order never depends on threads.
using Candidates = std::vector<Candidate>;

/// Sorts into the order of Candidates.
inline void rank(Candidates &candidates) {
  std::sort(candidates.begin(), candidates.end(), [](const Candidate &a, const Candidate &b) {
    if (a.strength != b.strength) return a.strength > b.strength;
    return a.at.y != b.at.y ? a.at.y < b.at.y : a.at.x < b.at.x;
  });
}

}  // namespace csd
