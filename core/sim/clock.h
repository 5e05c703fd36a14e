// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <opencv2/core.hpp>

namespace csd::sim {

/// The box of the burnt-in text in a picture of `size`: black, at the lower left.
cv::Rect clock_box(cv::Size size);

/// Burns the time (h:mm:ss.d) into a CV_8UC3 picture.
void draw_clock(double time, cv::Mat &picture);

}  // namespace csd::sim
