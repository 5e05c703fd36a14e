// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <opencv2/core.hpp>

namespace csd {

/// A map of patch offsets to source offsets: u, in pixels from the patch's centre (x right, y down), is seen at
/// centre + H·(u, 1), divided by its third component.
using Warp = cv::Matx33d;

/// Samples the square patch of odd `side` about `centre` (pixels of `source`, pixel centres at integers) through
/// `warp`, bilinearly; outside, the border goes on. With the identity and a centre at integers it is an exact copy.
///
/// `source` is CV_8UC1 or CV_8UC3, not empty; `out` becomes side × side of that type and must not be `source`.
/// Positions are rounded to 1/256 of a pixel. A position at or behind the warp's horizon takes the border in its
/// direction. Throws std::invalid_argument if `side` is even or less than 1, `centre` or `warp` not finite, or the type
/// another.
void sample_patch(const cv::Mat &source, cv::Point2d centre, int side, const Warp &warp, cv::Mat &out);
void sample_patch(const cv::Mat &source, cv::Point2d centre, int side, cv::Mat &out);  ///< without a warp

}  // namespace csd
