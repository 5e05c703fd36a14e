// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <opencv2/core.hpp>

namespace csd {

/// A homography from patch offsets to source offsets: u, in pixels from the patch's centre (x right, y down), is at
/// centre + H·(u, 1), divided by its third component.
using Warp = cv::Matx33d;

/// Samples the square patch of odd `side` at `centre` (pixels of `source`, pixel centres at integers) through `warp`,
/// bilinearly; outside, the border is replicated. With the identity and an integer centre it is an exact copy.
///
/// `source` is CV_8UC1 or CV_8UC3, not empty; `out` becomes side × side of that type and must not be `source`.
/// Positions are rounded to 1/256 of a pixel. A position at or behind the warp's horizon takes the border pixel in its
/// direction. Throws std::invalid_argument on another type, an even `side` or one below 1, or a `centre` or `warp` that
/// is not finite.
void sample_patch(const cv::Mat &source, cv::Point2d centre, int side, const Warp &warp, cv::Mat &out);
void sample_patch(const cv::Mat &source, cv::Point2d centre, int side, cv::Mat &out);  ///< without a warp

}  // namespace csd
