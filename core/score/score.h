// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <string>

#include "score/bootstrap.h"
#include "score/calibration.h"
#include "score/stir.h"

namespace csd::score {

/// A point of the curve over thresholds: means over clips.
struct CurvePoint {
  double pixels = 0;  ///< at 576 lines or less
  PaperScore paper;
};

/// The paper's scores on one clip.
struct ClipScore {
  double tau = 0;  ///< pixels
  PaperScore paper;
  Counts total;
  std::vector<Counts> frames;  ///< one for each of Clip::moments
};

/// All scores of one tracker. Scores without data are unknown.
struct TrackerScore {
  std::string name;

  Headlines headline{};  ///< means over clips
  std::array<Interval, headline_count> intervals{};
  std::vector<Headlines> draws;

  double k_visible = unknown;  ///< mean over clips
  Counts total;                ///< of all clips
  std::vector<CurvePoint> curve;

  Thresholds tap_vid_within{}, tap_vid_jaccard{};  ///< means over clips
  JaccardScore stir_2026;
  Stir2024Score stir_2024;
  double stir_2024_median = unknown;  ///< pixels
  Stir2024Score stir_2024_control;    ///< of a tracker that never moves

  double error_median = unknown, error_95 = unknown;  ///< pixels
  double error_first_fifth = unknown, error_last_fifth = unknown;
  double drift() const { return error_last_fifth - error_first_fifth; }

  std::size_t returns = 0, recovered = 0;    ///< of hidden features
  double recovery_median_frames = unknown;   ///< infinite: most never recover
  double recovery_median_seconds = unknown;  ///< also unknown if the truth has no pts

  Reliability reliability;
  std::vector<ClipScore> clips;
};

/// @param clips the tracker on each clip; not empty. @param resamples of the bootstrap; 0: no intervals
TrackerScore score(std::string name, std::span<const Clip> clips, unsigned resamples, std::uint64_t seed);

}  // namespace csd::score
