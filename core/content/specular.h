// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <opencv2/core.hpp>

namespace csd {

class WorkFrame;

/// Specular highlights are bright and unsaturated (§2.1.1: "thresholding in HSV space"); the paper gives no numbers.
struct SpecularOptions {
  double value = 0.86;       ///< V at least this, 0…1
  double saturation = 0.25;  ///< S at most this, 0…1
  double margin = 5;         ///< "close to": radius of the dilation, working pixels at 576 lines
};

/// Marks the pixels within the margin of a highlight: `mask` becomes CV_8UC1 of the size of `r`, 255 where marked.
///
/// `r` is a rectangle of the working image; highlights in the image but outside `r` count too. Pixels of `r` outside
/// the image are 0. A gray picture has no saturation, so luma alone decides. The margin scales with the image's height.
void specular_mask(const WorkFrame &frame, const cv::Rect &r, cv::Mat &mask, const SpecularOptions &options = {});

/// Radius of the dilation for a working image of `lines` lines, pixels.
int specular_margin(int lines, const SpecularOptions &options = {});

}  // namespace csd
