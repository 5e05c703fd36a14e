// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <cstdint>
#include <opencv2/imgproc.hpp>

namespace csd {

/// Smooth random texture, 120 ± 22 grey levels, its blobs a few pixels wide: CV_8UC1.
inline cv::Mat blob_texture(cv::Size size, std::uint64_t seed = 7) {
  cv::Mat noise(size, CV_32FC1), result;
  cv::RNG rng(seed);
  rng.fill(noise, cv::RNG::NORMAL, 0, 1);
  cv::GaussianBlur(noise, noise, {}, 3);
  noise.convertTo(result, CV_8U, 240, 120);
  return result;
}

/// The picture with sensor noise: normal, with deviation `sigma` in grey levels, different in each call.
inline cv::Mat with_noise(const cv::Mat &picture, double sigma, cv::RNG &rng) {
  cv::Mat noise(picture.size(), CV_16SC1), result;
  rng.fill(noise, cv::RNG::NORMAL, 0, sigma);
  cv::add(picture, noise, result, cv::noArray(), CV_8U);
  return result;
}

}  // namespace csd
