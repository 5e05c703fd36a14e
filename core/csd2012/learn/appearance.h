// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <opencv2/core.hpp>

#include "track/random.h"

namespace csd {

// How else a patch may look: the "more complex appearance models" of the paper's future work (§5), beside smoke
// (smoke.h). Each changes a CV_8UC3 patch in place and throws cv::Exception on another type. `pixel`: of a picture of
// 480 lines, in pixels of the patch.

/// Half axes of a highlight, pixels: the long one, and the short one as a share of it.
inline constexpr double highlight_axis[2] = {2, 6}, highlight_share[2] = {0.3, 1};
/// Length of the way that the camera or the tissue goes while the shutter is open, pixels.
inline constexpr double blur_length[2] = {5, 11};
/// Step by which a codec rounds the coefficients of a block, of intensities in 0…255: H.264's at QP 23 to 31.
inline constexpr double codec_step[2] = {9, 23};
/// Side of a codec's block.
inline constexpr int codec_block = 8;

/// A specular highlight: an ellipse of random place, size and direction, white within and with a short slope around it.
void add_highlight(cv::Mat &patch, double pixel, Random &random);
/// Motion blur along a random direction. The border is replicated.
void blur_by_motion(cv::Mat &patch, double pixel, Random &random);
/// What a codec leaves of it: blocks, at a random place of their grid, whose cosine coefficients are rounded.
void compress(cv::Mat &patch, Random &random);

}  // namespace csd
