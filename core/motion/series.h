// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <opencv2/core/types.hpp>

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "score/types.h"

/// How tracked tissue moves: displacement, velocity, and the rhythms in them. docs/motion.md has the definitions.
namespace csd::motion {

using score::unknown;

inline const cv::Point2d unknown_point{unknown, unknown};
inline bool known(const cv::Point2d &p) {
  return p.x == p.x;
}

/// Where one feature was claimed to be.
struct Path {
  FeatureId id = 0;
  std::vector<std::size_t> frames;     ///< ascending: indices into Series::times of the frames in which it is claimed
  std::vector<cv::Point2d> positions;  ///< px, in each of `frames`

  const cv::Point2d &start() const { return positions.front(); }
};

/// A position of a path.
struct Claim {
  std::size_t path = 0;   ///< index into Series::paths
  std::size_t place = 0;  ///< index into Path::positions
};

/// What is claimed, by time.
struct Series {
  std::vector<double> times;          ///< s, ascending: the frames' pts
  std::vector<std::uint64_t> frames;  ///< their numbers
  std::vector<Path> paths;            ///< ascending ids; only features that claim something
  double interval = 0;                ///< s, the median from a frame to the next; 0 of one frame

  /// The longest step, s, over which a difference is a velocity: two frames, and a half for jitter.
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
  std::optional<double> from, to;  ///< s of the frames' pts, both included; none: the file's begin or end
  double fps = 0;                  ///< frames a second, where the file has no pts
};

/// Throws score::InputError if no frame has a time (and Span::fps is 0), times go back, no frame is in the span,
/// nothing is claimed in it, or a position is a million pixels off. Frames without a time among frames that have one
/// are left out.
Series series_of(const score::Recording &tracks, const Span &span = {});

/// px/s, one for each of the path's positions: the slope, in a frame, of the parabola through the positions in the
/// frame before, in it and in the frame after; of the line through two where one of those is not claimed, or is more
/// than longest_step() away; unknown where neither is.
std::vector<cv::Point2d> velocities(const Series &series, const Path &path);

/// What the features do together, a value for each frame.
struct SceneMotion {
  std::vector<cv::Point2d> displacement;  ///< px from the first claims on: the sum of the median steps
  std::vector<cv::Point2d> velocity;      ///< px/s, the median of the features'
  std::vector<std::size_t> features;      ///< how many claim a position
};

/// Medians are by coordinate, of the features that claim a position in both frames of a step; so a feature that begins,
/// ends or is found again elsewhere moves nothing. What happens while nothing is claimed is left out; displacement and
/// velocity are unknown then.
SceneMotion scene_motion(const Series &series);

}  // namespace csd::motion
