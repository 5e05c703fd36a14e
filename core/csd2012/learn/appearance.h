// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <opencv2/core.hpp>

#include "base/random.h"

namespace csd {

// Further appearances of a patch: the "more complex appearance models" of the paper's future work (§5), beside smoke
// (smoke.h). Each changes a CV_8UC3 patch in place and throws cv::Exception on another type. `pixel`: of a picture of
// 480 lines, in pixels of the patch.

/// Half axes of a highlight, pixels: the long one, and the short one as a share of it.
inline constexpr double highlight_axis[2] = {2, 6}, highlight_share[2] = {0.3, 1};
/// Length of the motion during an exposure, pixels.
inline constexpr double blur_length[2] = {5, 11};
/// Quantisation step of a block's coefficients, for intensities in 0…255: H.264's at QP 23 to 31.
inline constexpr double codec_step[2] = {9, 23};
/// Side of a codec's block.
inline constexpr int codec_block = 8;

/// A specular highlight: an ellipse of random position, size and direction, white with a soft rim.
void add_highlight(cv::Mat &patch, double pixel, Random &random);
/// Motion blur along a random direction. The border is replicated.
void blur_by_motion(cv::Mat &patch, double pixel, Random &random);
/// Compression artefacts: quantises the cosine coefficients of blocks, with a random grid offset.
void compress(cv::Mat &patch, Random &random);

}  // namespace csd
