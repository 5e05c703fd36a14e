// SPDX-License-Identifier: LGPL-2.1-or-later
#include "detect/dog.h"

#include <opencv2/features2d.hpp>
#include <opencv2/imgproc.hpp>

#include <algorithm>

namespace csd {
namespace {

// Lowe's values.
constexpr int octave_layers = 3;
constexpr double contrast_threshold = 0.04;
constexpr double edge_threshold = 10;
constexpr double sigma = 1.6;

// In pixels of its picture: cv::SIFT doubles it about the pixels' centres, but halves positions as if about 0.
constexpr double sift_shift = 0.25;

constexpr int smallest_side = 16;

}  // namespace

Candidates find_dog(const cv::Mat &luma, const cv::Mat &allowed) {
  Candidates found;
  if (std::min(luma.cols, luma.rows) < smallest_side) return found;

  // cv::SIFT starts by doubling its picture. It gets ours at half size, so that its first octave has our resolution.
  // That takes a quarter of the time and misses only blobs of a pixel or two, which are noise beside a patch of 21.
  cv::Mat half;
  cv::resize(luma, half, {}, 0.5, 0.5, cv::INTER_AREA);
  const double scale_x = static_cast<double>(luma.cols) / half.cols;
  const double scale_y = static_cast<double>(luma.rows) / half.rows;

  std::vector<cv::KeyPoint> keypoints;
  cv::SIFT::create(0, octave_layers, contrast_threshold, edge_threshold, sigma)->detect(half, keypoints);
  found.reserve(keypoints.size());
  for (const cv::KeyPoint &k : keypoints) {
    const cv::Point2d at{(k.pt.x - sift_shift + 0.5) * scale_x - 0.5, (k.pt.y - sift_shift + 0.5) * scale_y - 0.5};
    const cv::Point pixel{cvRound(at.x), cvRound(at.y)};
    if (pixel.inside({0, 0, luma.cols, luma.rows}) && allowed.at<std::uint8_t>(pixel) != 0) {
      found.push_back({at, k.response});
    }
  }
  rank(found);
  // An extremum with several dominant orientations appears once for each.
  const auto same = [](const Candidate &a, const Candidate &b) { return a.at == b.at && a.strength == b.strength; };
  found.erase(std::unique(found.begin(), found.end(), same), found.end());
  return found;
}

}  // namespace csd
