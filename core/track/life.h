// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <opencv2/core.hpp>

#include <cstdint>

#include "track/algorithm.h"
#include "track/types.h"

namespace csd {

/// A feature from its first frame to its last.
struct Life {
  Feature feature;              ///< what is told of it
  bool given = false;           ///< by the user: never ends by itself
  bool begun = false;           ///< the algorithm knows of it
  std::int64_t gone_since = 0;  ///< when it became lost or out
  cv::Point2d start, claimed;   ///< where it began, and where it was seen last; picture pixels
  std::int64_t last_claim = 0;  ///< when a position was last claimed
  bool reported = false;        ///< in an earlier frame
  FeatureState reported_as = FeatureState::learning;
  bool surrounded = false;  ///< the last claim's

  /// Detection put it where it alone was hidden before it was learnt: most likely at the edge of a tool or a highlight,
  /// which moves against the tissue. An anchor of both would be found on the tool again later.
  bool started_falsely() const;

  /// Nothing more will be told of it.
  void end();

  /// What the algorithm says of the frame at `time` (ns) becomes the feature's state, position and confidence.
  void apply(const Claim &claim, std::int64_t time);
};

}  // namespace csd
