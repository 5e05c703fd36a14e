// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <string>
#include <vector>

#include "score/score.h"

namespace csd::programs {

/// All results of csd-score.
struct ScoreReport {
  struct ClipFacts {
    std::string truth;
    int width, height;
    std::size_t features;
    std::vector<score::Moment> moments;  ///< labelled frames
    std::vector<std::string> tracks;     ///< one per tracker
  };
  struct Pair {
    std::size_t tracker;  ///< compared with tracker 0
    std::array<score::Comparison, score::headline_count> comparisons;
  };
  std::vector<ClipFacts> clips;
  std::vector<score::TrackerScore> trackers;
  std::vector<Pair> pairs;
  std::vector<std::string> notes;
  unsigned resamples = 0;
};

/// @param clips [tracker][clip]
ScoreReport make_report(const std::vector<std::string> &names, const std::vector<std::vector<score::Clip>> &clips,
                        std::vector<std::string> notes, unsigned resamples);

std::string as_text(const ScoreReport &report);
std::string as_markdown(const ScoreReport &report);
/// tracker,clip,metric,threshold,value,low,high: `clip` is empty for values over all clips; unknown values are empty.
std::string as_csv(const ScoreReport &report);
/// docs/metrics.md describes it. Unknown or infinite values are null.
std::string as_json(const ScoreReport &report);

}  // namespace csd::programs
