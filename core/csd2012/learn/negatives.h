// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <opencv2/core.hpp>

#include <vector>

#include "base/random.h"

namespace csd {

/// Where negatives may lie: the paper asks for "every position that is not the feature", and finds that patches "within
/// a few pixels" look alike. Positions in between are not used.
struct NegativeRules {
  int patch;             ///< odd side, working pixels: the whole patch lies inside the picture
  double ignore_radius;  ///< negatives keep this distance from the feature
  /// A third of the random negatives lie within this radius: they determine the localisation accuracy.
  double near_radius;
};

/// `count` random positions of patches "not a feature" (§2.1.2.1): a third near the feature, the rest anywhere. Fewer
/// if the picture has no room. `forbidden`: CV_8UC1 of the picture's size or empty; positions where it is set are
/// excluded.
std::vector<cv::Point> random_negatives(cv::Size picture, const cv::Mat &forbidden, cv::Point feature, int count,
                                        const NegativeRules &rules, Random &random);

/// Up to `count` positions that look like the feature (§2.1.2.1): the highest local maxima, at least `min_score`, of
/// the normalised cross correlation of the patch around `feature` with the surroundings of ±`radius` pixels; best
/// first. `luma`: CV_8UC1.
std::vector<cv::Point> similar_negatives(const cv::Mat &luma, const cv::Mat &forbidden, cv::Point feature, int count,
                                         double min_score, int radius, const NegativeRules &rules);

}  // namespace csd
