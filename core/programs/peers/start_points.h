// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <opencv2/core/types.hpp>

#include <cstddef>
#include <string>
#include <vector>

#include "base/types.h"

namespace csd::peers {

struct StartPoints {
  std::vector<FeatureId> ids;
  std::vector<cv::Point2d> positions;  ///< in the first frame, pixels
  int width = 0, height = 0;           ///< of their picture; 0: unknown
};

/// "x,y;x,y;…" (ids 0, 1, 2…), or the name of a file with ground truth or tracks: the points visible in its first
/// frame, which must be frame 0, under their ids. Accepts the same files as csd-score. Throws std::runtime_error that
/// says what is wrong where.
StartPoints read_start_points(const std::string &text_or_file);

/// At most `wanted` of them (0: all), spread evenly over the list: detection lists the best first.
StartPoints thinned(const StartPoints &points, std::size_t wanted);

}  // namespace csd::peers
