// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <opencv2/core.hpp>

#include "image/colour_space.h"

namespace csd {

/// Converts a CV_8UC3 picture (B G R) to one colour space: `out` becomes CV_8UC1 of its size. Throws cv::Exception on
/// another type.
void to_space(const cv::Mat &bgr, const ColourSpace &space, cv::Mat &out);

}  // namespace csd
