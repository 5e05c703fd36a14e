// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <opencv2/core.hpp>

#include <span>
#include <vector>

namespace csd {

struct DetectOptions {
  int patch = 21;             ///< odd side of the patch, working pixels
  std::size_t wanted = 50;    ///< most features to find
  double max_look_alike = 1;  ///< limit of a feature's LookAlikes::best()
};

/// Finds features to track (§2.1.1): Difference of Gaussian and Shi–Tomasi, merged and spread over the picture.
///
/// `luma` is CV_8UC1, the working image. `specular` and `forbidden` are CV_8UC1 of its size, or empty. At most 5 % of a
/// feature's patch may have `specular` ≠ 0; its centre must have `forbidden` = 0. `taken` are existing features: new
/// ones stay half a patch away from them and fill empty areas first. Every patch lies entirely inside the picture.
///
/// The result is in working pixels (centres at integers), best first, and depends only on the arguments. It is empty
/// for a picture smaller than a patch or without texture.
std::vector<cv::Point2d> detect(const cv::Mat &luma, const cv::Mat &specular, const cv::Mat &forbidden,
                                const DetectOptions &options, std::span<const cv::Point2d> taken = {});

/// Where the rules above allow a patch's centre: CV_8UC1 of the luma's size, 255 or 0.
cv::Mat allowed_centres(cv::Size size, const cv::Mat &specular, const cv::Mat &forbidden, int patch);

}  // namespace csd
