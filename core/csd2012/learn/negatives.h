// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <opencv2/core.hpp>

#include <vector>

#include "track/random.h"

namespace csd {

/// Where negatives may be taken: the paper asks for "every position that is not the feature", and finds that patches
/// "within a few pixels" look alike. Nothing is learnt from the ring in between.
struct NegativeRules {
  int patch;             ///< odd side, working pixels: the whole patch lies inside the picture
  double ignore_radius;  ///< nearer than this to the feature nothing is a negative
  /// A third of the random negatives come from within this: they set how sharply it localises.
  double near_radius;
};

/// `count` random positions of patches "not a feature" (§2.1.2.1): a third of them near the feature, the rest anywhere.
/// Fewer where the picture has no room. `forbidden`: CV_8UC1 of the picture's size or empty; not taken where it is set.
std::vector<cv::Point> random_negatives(cv::Size picture, const cv::Mat &forbidden, cv::Point feature, int count,
                                        const NegativeRules &rules, Random &random);

/// Up to `count` positions that look like the feature (§2.1.2.1): the highest local maxima, at least `least`, of
/// the normalised cross correlation of the patch around `feature` with the surroundings of ±`radius` pixels; best
/// first. `luma`: CV_8UC1.
std::vector<cv::Point> similar_negatives(const cv::Mat &luma, const cv::Mat &forbidden, cv::Point feature, int count,
                                         double least, int radius, const NegativeRules &rules);

}  // namespace csd
