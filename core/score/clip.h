// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>

#include "score/types.h"

namespace csd::score {

/// The truth and the report on one feature in one labelled frame.
struct Sample {
  Presence presence = Presence::unlabelled;
  bool reported = false;  ///< the tracker listed it in exactly this frame
  bool claimed = false;   ///< the tracker claimed a position
  /// Reported − true position in pixels. Without a claim it uses the last reported position. Infinite if either is
  /// unknown.
  double dx = std::numeric_limits<double>::infinity(), dy = dx;
  double confidence = 0;

  bool labelled() const { return presence != Presence::unlabelled; }
  bool visible() const { return presence == Presence::visible; }
  double distance() const { return std::hypot(dx, dy); }
};

struct Moment {
  std::uint64_t frame = 0;
  std::int64_t pts = no_time;
};

/// A tracker's reports on one clip with its truth.
struct Clip {
  std::string truth, tracks;  ///< file names
  int width = 0, height = 0;
  std::vector<FeatureId> ids;
  std::vector<Moment> moments;  ///< the labelled frames, ascending; empty if the truth has no identities
  std::vector<Sample> samples;  ///< ids × moments

  std::vector<cv::Point2d> starts;  ///< the points visible in the first labelled frame, …
  std::vector<cv::Point2d> ends;    ///< … those visible in the last, in an unrelated order …
  std::vector<cv::Point2d>
      reports_last;  ///< … and where the tracker says that each of `starts` went (infinite: nowhere)

  Sample &at(std::size_t feature, std::size_t moment) { return samples[feature * moments.size() + moment]; }
  const Sample &at(std::size_t feature, std::size_t moment) const { return samples[feature * moments.size() + moment]; }
};

/// `pixels` at 576 lines or less, scaled up above (docs/metrics.md: τ).
inline double tolerance(int height, double pixels) {
  return pixels * std::max(1.0, height / 576.0);
}

}  // namespace csd::score
