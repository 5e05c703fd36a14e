// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <opencv2/core/types.hpp>

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "score/types.h"

/// Motion of tracked tissue: displacement, velocity, and their rhythms. docs/motion.md has the definitions.
namespace csd::motion {

using score::unknown;

inline const cv::Point2d unknown_point{unknown, unknown};
inline bool known(const cv::Point2d &p) {
  return p.x == p.x;
}

/// The claimed positions of one feature.
struct Path {
  FeatureId id = 0;
  std::vector<std::size_t> frames;     ///< ascending: indices into Series::times of the frames with a claim
  std::vector<cv::Point2d> positions;  ///< px, one for each of `frames`

  const cv::Point2d &start() const { return positions.front(); }
};

/// A position on a path.
struct Claim {
  std::size_t path = 0;   ///< index into Series::paths
  std::size_t place = 0;  ///< index into Path::positions
};

/// The claimed positions by time.
struct Series {
  std::string clock;                  ///< `times` are the frames' pts, stream_time or running_time; "": by Span::fps
  std::vector<double> times;          ///< s, ascending; frames may have the same
  std::vector<std::uint64_t> frames;  ///< frame numbers
  std::vector<Path> paths;            ///< ascending ids; only features with claims
  double interval = 0;                ///< s, the median time between frames; 0 without a later one

  std::size_t left_out = 0;               ///< frames of a picture of another size than the first …
  int other_width = 0, other_height = 0;  ///< … that of the first of them …
  std::size_t other_line = 0;             ///< … and its line

  /// The longest step, s, over which a difference counts as a velocity: two frames, and half a frame for jitter.
  double longest_step() const { return 2.5 * interval; }
};

/// The claims of each frame, by ascending ids.
class ClaimsByFrame {
 public:
  explicit ClaimsByFrame(const Series &series);
  std::span<const Claim> at(std::size_t frame) const {
    return {claims_.data() + ends_[frame], claims_.data() + ends_[frame + 1]};
  }

 private:
  std::vector<std::size_t> ends_;
  std::vector<Claim> claims_;
};

struct Span {
  std::optional<double> from, to;  ///< s of Series::times, inclusive; none: start or end of the file
  double fps = 0;                  ///< frames per second, if the file has no pts
};

/// Times are the first of pts, stream_time and running_time that never goes back. Throws score::InputError if no frame
/// has one (and Span::fps is 0), all go back, the span has no frame or no claims, or a position is a million pixels
/// off. Drops frames without a time if others have one, and frames of another size than the first.
Series series_of(const score::Recording &tracks, const Span &span = {});

/// px/s, for each of the path's positions: the slope of the parabola through the positions in the frame and its two
/// neighbours. If one neighbour has no claim, the same time, or is more than longest_step() away, the slope of the line
/// to the other; unknown if neither is usable.
std::vector<cv::Point2d> velocities(const Series &series, const Path &path);

/// The common motion of the features, a value for each frame.
struct SceneMotion {
  std::vector<cv::Point2d> displacement;  ///< px since the first claims: the sum of the median steps
  std::vector<cv::Point2d> velocity;      ///< px/s, the median of the features'
  std::vector<std::size_t> features;      ///< number of features that claim a position
};

/// Medians are per coordinate, over the features that claim a position in both frames of a step, so a feature that
/// starts, ends or is found again elsewhere has no effect. Times without claims are skipped; displacement and velocity
/// are unknown there.
SceneMotion scene_motion(const Series &series);

}  // namespace csd::motion
