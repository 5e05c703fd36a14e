// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <opencv2/core/types.hpp>

#include <cstdint>
#include <limits>
#include <stdexcept>
#include <string>
#include <vector>

#include "track/types.h"

/// Scores tracks against ground truth. The definitions are in docs/metrics.md.
namespace csd::score {

inline constexpr double unknown = std::numeric_limits<double>::quiet_NaN();  ///< a score that nothing speaks for

/// What is wrong with an input. what() is "FILE:LINE: TEXT", or "FILE: TEXT" where no line is to blame (line 0).
struct InputError : std::runtime_error {
  InputError(const std::string &file, std::size_t line, const std::string &text)
      : std::runtime_error(file + (line ? std::string(":").append(std::to_string(line)) : "") + ": " + text) {}
};

/// Where a feature is in a frame, by the truth.
enum class Presence : std::uint8_t {
  unlabelled,  ///< nobody said: not scored
  visible,
  hidden,  ///< in the picture, behind something
  out,     ///< outside the picture
};

struct TruthPoint {
  Presence presence = Presence::unlabelled;
  cv::Point2d position{unknown, unknown};  ///< pixels, centres at integers; unknown only where not visible
};

struct TruthFrame {
  std::uint64_t frame = 0;
  std::int64_t pts = no_time;      ///< ns; no_time: the truth doesn't say
  std::size_t line = 0;            ///< of its file; 0: the file has no lines
  std::vector<TruthPoint> points;  ///< one for each of Truth::ids
};

struct Truth {
  std::string file;
  int width = 0, height = 0;       ///< of the picture; 0: unknown
  std::vector<FeatureId> ids;      ///< ascending
  std::vector<TruthFrame> frames;  ///< ascending; those that are labelled
  /// STIR: where the points end, but not which is which. Then `frames` is the first frame alone.
  std::vector<cv::Point2d> end_points;
  bool identified = true;  ///< false: `end_points` are all that is known of the end
};

struct TrackFrame {
  bool numbered = true;  ///< false: a line without metadata, `frame` is unknown
  std::uint64_t frame = 0;
  std::int64_t pts = no_time;
  std::size_t line = 0;
  std::vector<Feature> features;  ///< ascending ids
};

/// What a tracker reported, as csdtrackenc wrote it.
struct Recording {
  std::string file;
  std::string algorithm;      ///< "" where the file doesn't say
  int width = 0, height = 0;  ///< 0: unknown
  bool sparse = false;        ///< CSV: a frame without features has no row
  std::vector<TrackFrame> frames;
};

}  // namespace csd::score
