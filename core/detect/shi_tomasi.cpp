// SPDX-License-Identifier: LGPL-2.1-or-later
#include "detect/shi_tomasi.h"

#include <opencv2/imgproc.hpp>

namespace csd {
namespace {

constexpr double quality_level = 0.005;  // of the best corner's eigenvalue
constexpr int sobel_size = 3;

// The eigenvalue is the mean square slope along the weaker direction. A slope of one grey level a pixel is what coding
// leaves in a black picture.
constexpr float least_eigenvalue = 1.0F / (255 * 255);

}  // namespace

Candidates find_shi_tomasi(const cv::Mat &luma, const cv::Mat &allowed, int window, double distance) {
  std::vector<cv::Point2f> corners;
  std::vector<float> eigenvalues;
  cv::goodFeaturesToTrack(luma, corners, 0, quality_level, distance, allowed, eigenvalues, window, sobel_size);
  Candidates found;
  found.reserve(corners.size());
  for (std::size_t i = 0; i < corners.size(); ++i) {
    if (eigenvalues[i] >= least_eigenvalue) found.push_back({corners[i], eigenvalues[i]});
  }
  rank(found);
  return found;
}

}  // namespace csd
