// SPDX-License-Identifier: LGPL-2.1-or-later
#include "detect/shi_tomasi.h"

#include <opencv2/imgproc.hpp>

#include <algorithm>
#include <cstdlib>
#include <vector>

namespace csd {
namespace {

constexpr double quality_level = 0.005;  // of the best corner's eigenvalue
constexpr int sobel_size = 3;

// The eigenvalue is the mean square slope along the weaker direction. Coding a black picture leaves slopes of one grey
// level a pixel.
constexpr float min_eigenvalue = 1.0F / (255 * 255);

constexpr int noise_rows = 2, noise_columns = 4;  // the noise is estimated on this subsampled grid

// Upper limit of noise: its mean times 1 + this/window. Measured on white noise of 1024×576, the largest eigenvalue is
// 5.2, 2.5, 1.5 and 1.2 times the mean with windows of 3, 7, 21 and 35.
constexpr double noise_spread = 13;

/// The standard deviation of the picture's noise, grey levels: Immerkær's mask (1996), which ignores planes and
/// axis-parallel edges, but with the median, to suppress texture.
double noise_deviation(const cv::Mat &luma, const cv::Mat &allowed) {
  std::vector<int> histogram(8 * 255 + 1);
  int n = 0;
  for (int y = 1; y + 1 < luma.rows; y += noise_rows) {
    const auto *above = luma.ptr<std::uint8_t>(y - 1), *here = luma.ptr<std::uint8_t>(y);
    const auto *below = luma.ptr<std::uint8_t>(y + 1), *asked = allowed.ptr<std::uint8_t>(y);
    for (int x = 1; x + 1 < luma.cols; x += noise_columns) {
      if (asked[x] == 0) continue;
      const auto across = [x](const std::uint8_t *row) { return row[x - 1] - 2 * row[x] + row[x + 1]; };
      ++histogram[static_cast<std::size_t>(std::abs(across(above) - 2 * across(here) + across(below)))];
      ++n;
    }
  }
  int median = 0;
  for (int count = histogram[0]; 2 * count < n; count += histogram[static_cast<std::size_t>(median)]) ++median;
  // The mask's response to noise of deviation 1 is 6; a normal distribution's deviation is 1.4826 medians.
  return (median + 0.5) * 1.4826 / 6;
}

/// The largest smaller eigenvalue in pure noise. The mean is four times (OpenCV's scale) that of the squared Sobel
/// slope, 12/64 of the variance.
double noise_eigenvalue(double deviation, int window) {
  const double mean = 4 * 12.0 / 64 * deviation * deviation / (255 * 255);
  return mean * (1 + noise_spread / window);
}

}  // namespace

Candidates find_shi_tomasi(const cv::Mat &luma, const cv::Mat &allowed, int window, double distance) {
  std::vector<cv::Point2f> corners;
  std::vector<float> eigenvalues;
  cv::goodFeaturesToTrack(luma, corners, 0, quality_level, distance, allowed, eigenvalues, window, sobel_size);
  const double min_strength =
      std::max<double>(min_eigenvalue, noise_eigenvalue(noise_deviation(luma, allowed), window));
  Candidates found;
  found.reserve(corners.size());
  for (std::size_t i = 0; i < corners.size(); ++i) {
    if (eigenvalues[i] >= min_strength) found.push_back({corners[i], eigenvalues[i]});
  }
  rank(found);
  return found;
}

}  // namespace csd
