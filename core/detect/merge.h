// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <span>
#include <vector>

#include "detect/candidate.h"

namespace csd {

/// Alternates two detectors' candidates by rank (first of `a`, first of `b`, second of `a`, …) and drops each that is
/// closer than `radius` working pixels to an earlier one or to one of `taken`. Keeps the order.
std::vector<cv::Point2d> merge_by_rank(const Candidates &a, const Candidates &b, double radius,
                                       std::span<const cv::Point2d> taken = {});

/// Chooses `wanted` of `ranked` to cover a picture of `size`: the best of each square bucket of `bucket` working pixels
/// first, then the second best of each, and so on. `taken` ones count as already chosen. Keeps the order of `ranked`.
std::vector<cv::Point2d> spread(const std::vector<cv::Point2d> &ranked, cv::Size size, double bucket,
                                std::size_t wanted, std::span<const cv::Point2d> taken = {});

}  // namespace csd
