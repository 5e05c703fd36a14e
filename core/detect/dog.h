// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include "detect/candidate.h"

namespace csd {

/// Difference-of-Gaussian extrema (§2.1.1; Lowe 2004), at most one per place.
///
/// `luma` and `allowed` are CV_8UC1 of one size; candidates lie where `allowed` is not 0. A picture of less than
/// 16 pixels a side has none.
Candidates find_dog(const cv::Mat &luma, const cv::Mat &allowed);

}  // namespace csd
