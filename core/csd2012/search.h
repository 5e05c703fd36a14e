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

/// Positions that a descriptor calls "feature", and the best of them (§2.1.4).
struct SearchResult {
  std::optional<cv::Point2d> best;  ///< none: the feature is hidden
  double weighted = 0;              ///< of the best patch or cluster: its probability times the weight of its place
  std::vector<cv::Point> matches;   ///< all positions labelled feature, row by row
};

/// What is taken for the feature. Patches that lie together may be taken together, for "image patches around the true
/// location may be visually similar" (§2.1.4).
struct Best {
  int cluster_radius = 0;      ///< half of a cluster's side; 0: each patch is for itself
  double min_probability = 0;  ///< weighted: with less, the feature is hidden
};

/// Where to look: each `step`-th position of each `step`-th line of `centres` (working pixels).
struct SearchArea {
  cv::Rect centres;
  int step = 1;
};

/// The spatial weight of §2.1.4: a Gaussian around the last known position, working pixels. Infinite sigma: none.
struct SpatialWeight {
  cv::Point2d last;
  double sigma = std::numeric_limits<double>::infinity();
};

/// How far from its last position a feature is looked for, working pixels.
struct Reach {
  double sigma;  ///< of the spatial weight
  int radius;    ///< of the square window
};

/// The reach in a picture of `width` for a feature that could be seen in the frame `absence` ns before the last one: 0
/// if it was seen in that. `radius`: the reach's then.
Reach reach_after(const csd2012::Choices &choices, std::int64_t absence, int width, int radius);

/// §2.1.4: the patch labelled feature with the largest P(N) = |a|·|b|⁻¹ times the spatial weight; equals go to the
/// nearest to the last position, then to the first. With clusters: the square of patches whose sum of P(N) times the
/// weight of its middle is the largest, and of it the centroid of P(N).
///
/// `channel`: CV_8UC1 in the descriptor's colour space, whose pixel (0,0) is `origin` in working coordinates; the
/// patches around all centres lie in it.
SearchResult search(const Forest &descriptor, const cv::Mat &channel, cv::Point origin, const SearchArea &area,
                    const SpatialWeight &weight, const Best &wanted = {});

}  // namespace csd
