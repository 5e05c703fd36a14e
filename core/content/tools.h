// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <opencv2/core.hpp>

namespace csd {

class WorkFrame;

/// Finds tools by colour: metal and plastic are grey, lit tissue hardly ever is. Only for the choice of new points:
/// overexposed or burnt tissue passes for a tool, and a coloured tool for tissue.
///
/// `mask` becomes CV_8UC1 of the working size. It is 255 where the saturation (max − min)/max of B, G and R is below
/// .14 and below .6 of the picture's median (smoke desaturates all of it), and within 12 pixels at 480 lines (half a
/// patch) of that; else 0. Saturation is averaged over about 12 pixels; pixels darker than 32 of 255 are ignored. A
/// gray picture has no tools.
void find_tools(const WorkFrame &frame, cv::Mat &mask);

}  // namespace csd
