// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include "detect/candidate.h"

namespace csd {

/// Corners in the sense of Shi & Tomasi 1994 (§2.1.1): local maxima of the smaller eigenvalue of the structure tensor,
/// at least `distance` working pixels from each other.
///
/// `luma` and `allowed` are CV_8UC1 of one size; corners lie where `allowed` is not 0. `window` is the odd side,
/// working pixels, of the square that the tensor is summed over. Candidate::strength is the eigenvalue with intensities
/// in 0…1. What the picture's own noise gives is no corner; the noise is estimated where `allowed` is not 0.
Candidates find_shi_tomasi(const cv::Mat &luma, const cv::Mat &allowed, int window, double distance);

}  // namespace csd
