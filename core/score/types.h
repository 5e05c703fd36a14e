// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <opencv2/core/types.hpp>

#include <cstdint>
#include <limits>
#include <stdexcept>
#include <string>
#include <vector>

#include "base/types.h"

/// Scores tracks against ground truth. The definitions are in docs/metrics.md.
namespace csd::score {

inline constexpr double unknown = std::numeric_limits<double>::quiet_NaN();  ///< a score without data

/// An error in an input. what() is "FILE:LINE: TEXT", or "FILE: TEXT" without a line (line 0).
struct InputError : std::runtime_error {
  InputError(const std::string &file, std::size_t line, const std::string &text)
      : std::runtime_error(file + (line ? std::string(":").append(std::to_string(line)) : "") + ": " + text) {}
};

/// Where a feature is in a frame, according to the truth.
enum class Presence : std::uint8_t {
  unlabelled,  ///< no label: not scored
  visible,
  hidden,  ///< in the picture, behind something
  out,     ///< outside the picture
};

struct TruthPoint {
  Presence presence = Presence::unlabelled;
  cv::Point2d position{unknown, unknown};  ///< pixels, centres at integers; may only be unknown if not visible
};

struct TruthFrame {
  std::uint64_t frame = 0;
  std::int64_t pts = no_time;      ///< ns; no_time: unknown
  std::size_t line = 0;            ///< in its file; 0: the file has no lines
  std::vector<TruthPoint> points;  ///< one for each of Truth::ids
};

struct Truth {
  std::string file;
  int width = 0, height = 0;       ///< of the picture; 0: unknown
  std::vector<FeatureId> ids;      ///< ascending
  std::vector<TruthFrame> frames;  ///< ascending; only labelled ones
  /// STIR: the end points, in unknown order. `frames` is then only the first frame.
  std::vector<cv::Point2d> end_points;
  bool identified = true;  ///< false: `end_points` is the only truth about the end
};

struct TrackFrame {
  bool numbered = true;  ///< false: a line without metadata; `frame` is unknown
  std::uint64_t frame = 0;
  std::int64_t pts = no_time;
  std::size_t line = 0;
  std::vector<Feature> features;  ///< ascending ids
  std::int64_t stream_time = no_time, running_time = no_time;
  int width = 0, height = 0;  ///< of the picture; 0: unknown
};

/// A tracker's reports, as csdtrackenc wrote them.
struct Recording {
  std::string file;
  std::string algorithm;      ///< "" if the file has none
  int width = 0, height = 0;  ///< of the first picture; 0: unknown
  bool sparse = false;        ///< CSV: a frame without features has no row
  std::vector<TrackFrame> frames;

  /// Whether a frame's picture has another size than the first.
  bool has_other_size(const TrackFrame &frame) const {
    return frame.width > 0 && frame.height > 0 && (frame.width != width || frame.height != height);
  }
  /// Throws InputError if the picture's size changes: what is compared must be in the same pixels.
  void check_one_size() const {
    for (const TrackFrame &frame : frames)
      if (has_other_size(frame)) throw InputError(file, frame.line, "the picture's size changes");
  }
};

}  // namespace csd::score
