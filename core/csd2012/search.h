// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <opencv2/core.hpp>

#include <cstdint>
#include <limits>
#include <optional>
#include <vector>

#include "csd2012/choices.h"
#include "csd2012/learn/forest.h"

namespace csd {

/// The positions that a descriptor labels "feature", and the best of them (§2.1.4).
struct SearchResult {
  std::optional<cv::Point2d> best;  ///< empty: the feature is hidden
  double weighted = 0;              ///< of the best patch or cluster: its probability times its spatial weight
  std::vector<cv::Point> matches;   ///< all positions labelled feature, row by row
};

/// How the best position is chosen. Neighbouring patches may be combined, because "image patches around the true
/// location may be visually similar" (§2.1.4).
struct Best {
  int cluster_radius = 0;      ///< half of a cluster's side; 0: single patches
  double min_probability = 0;  ///< weighted; below, the feature is hidden
  double likeness_power = 0;   ///< P(N) counts times the likeness to the leaf's own patches to this power; 0: alone
};

/// The positions to search: each `step`-th position of each `step`-th line of `centres` (working pixels).
struct SearchArea {
  cv::Rect centres;
  int step = 1;
};

/// The spatial weight of §2.1.4: a Gaussian around the last known position, working pixels. Infinite sigma: none.
struct SpatialWeight {
  cv::Point2d last;
  double sigma = std::numeric_limits<double>::infinity();
};

/// How far from its last position a feature is searched for, working pixels.
struct Reach {
  double sigma;  ///< of the spatial weight
  int radius;    ///< of the square window
};

/// The search area in a picture of `width` for a feature last seen `absence` ns before the last frame; 0: seen in the
/// last frame. `radius`: the radius then.
Reach reach_after(const csd2012::Choices &choices, std::int64_t absence, int width, int radius);

/// §2.1.4: the patch labelled feature with the largest P(N) = |a|·|b|⁻¹ times the spatial weight; among equals the
/// nearest to the last position, then the first. With clusters: the square of patches with the largest sum of P(N)
/// times the weight of its centre; the position is its centroid of P(N).
///
/// `channel`: CV_8UC1 in the descriptor's colour space; its pixel (0,0) is `origin` in working coordinates. It must
/// contain the patches around all centres.
SearchResult search(const Forest &descriptor, const cv::Mat &channel, cv::Point origin, const SearchArea &area,
                    const SpatialWeight &weight, const Best &wanted = {});

}  // namespace csd
