// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <opencv2/core.hpp>

namespace csd {

class WorkFrame;

/// Where tools are, as far as colour tells: metal and plastic are grey, lit tissue hardly ever is. For choosing new
/// points, no more: tissue that is white with light, or burnt, passes for a tool too, and a coloured tool for tissue.
///
/// `mask` becomes CV_8UC1 of the working size, 255 on what has a lower saturation, (max − min)/max of B, G and R,
/// than .14, and than .6 of the picture's median (smoke takes colour from all of it), and up to 12 pixels at 480 lines
/// (half a patch) around that; else 0. In means over some 12 pixels; what is darker than 32 of 255 tells nothing. A
/// gray picture has none.
void find_tools(const WorkFrame &frame, cv::Mat &mask);

}  // namespace csd
