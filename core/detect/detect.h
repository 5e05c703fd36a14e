// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <opencv2/core.hpp>

#include <span>
#include <vector>

namespace csd {

struct DetectOptions {
  int patch = 21;           ///< odd side of the patch, working pixels
  std::size_t wanted = 50;  ///< at most so many features
  double max_likeness = 1;  ///< LookAlikes::best() of a feature, at most
};

/// Finds features to track (§2.1.1): Difference of Gaussian and Shi–Tomasi, merged and spread over the picture.
///
/// `luma` is CV_8UC1, the working image. `specular` and `forbidden` are CV_8UC1 of its size, or empty: a feature's
/// patch has at most 5 % of its pixels where `specular` is not 0, and its centre lies where
/// `forbidden` is 0. `taken` are features that exist: new ones keep half a patch away from them and go first where they
/// are not. Every patch lies wholly inside the picture.
///
/// The result is in working pixels (centres at integers), best first, and depends on nothing but the arguments. It is
/// empty for a picture smaller than a patch or without texture.
std::vector<cv::Point2d> detect(const cv::Mat &luma, const cv::Mat &specular, const cv::Mat &forbidden,
                                const DetectOptions &options, std::span<const cv::Point2d> taken = {});

/// Where a patch may be centred, by the rules above: CV_8UC1 of the luma's size, 255 or 0.
cv::Mat allowed_centres(cv::Size size, const cv::Mat &specular, const cv::Mat &forbidden, int patch);

}  // namespace csd
