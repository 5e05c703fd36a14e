// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <opencv2/core.hpp>

#include <cstdint>

#include "base/types.h"
#include "track/algorithm.h"

namespace csd {

/// A feature from its first frame to its last.
struct Life {
  Feature feature;              ///< as reported
  bool given = false;           ///< by the user: never ends by itself
  bool begun = false;           ///< the algorithm tracks it
  std::int64_t gone_since = 0;  ///< when it became lost or out
  cv::Point2d start, claimed;   ///< where it began; where it was last visible; picture pixels
  std::int64_t last_claim = 0;  ///< when a position was last claimed
  bool reported = false;        ///< in an earlier frame
  FeatureState reported_as = FeatureState::learning;
  bool surrounded = false;  ///< the last claim's

  /// Detection placed it, and it alone was hidden while still learning. It is most likely on the edge of a tool or a
  /// highlight, which moves against the tissue. An anchor of both would later be found on the tool.
  bool started_falsely() const;

  /// Ends the feature.
  void end();

  /// Sets the feature's state, position and confidence from the algorithm's claim for the frame at `time` (ns).
  void apply(const Claim &claim, std::int64_t time);
};

}  // namespace csd
