// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include "detect/candidate.h"

namespace csd {

/// Corners as defined by Shi & Tomasi 1994 (§2.1.1): local maxima of the smaller eigenvalue of the structure tensor, at
/// least `distance` working pixels apart.
///
/// `luma` and `allowed` are CV_8UC1 of one size; corners lie where `allowed` is not 0. `window` is the odd side,
/// working pixels, of the square over which the tensor is summed. Candidate::strength is the eigenvalue with
/// intensities in 0…1. Corners below the picture's noise level are rejected; the noise is estimated where `allowed` is
/// not 0.
Candidates find_shi_tomasi(const cv::Mat &luma, const cv::Mat &allowed, int window, double distance);

}  // namespace csd
