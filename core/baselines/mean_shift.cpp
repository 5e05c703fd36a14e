// SPDX-License-Identifier: LGPL-2.1-or-later
#include "baselines/mean_shift.h"

namespace csd {

namespace {
constexpr int max_steps = 20;
constexpr double min_step = 0.5;  // pixels
}  // namespace

WindowMass window_mass(const cv::Mat &values, const ColourWeights &weights, cv::Point2d centre, int side) {
  CV_Assert(values.type() == CV_8UC1 && side % 2 == 1);
  const cv::Rect window = cv::Rect(cvRound(centre.x) - side / 2, cvRound(centre.y) - side / 2, side, side) &
                          cv::Rect({0, 0}, values.size());
  std::uint64_t mass = 0, moment_x = 0, moment_y = 0;  // relative to the window's first pixel
  for (int y = 0; y < window.height; ++y) {
    const auto *row = values.ptr(window.y + y) + window.x;
    std::uint64_t in_row = 0;
    for (int x = 0; x < window.width; ++x) {
      const std::uint64_t w = weights[row[x]];
      in_row += w;
      moment_x += w * static_cast<std::uint64_t>(x);
    }
    mass += in_row;
    moment_y += in_row * static_cast<std::uint64_t>(y);
  }
  if (mass == 0) return {0, centre};
  const auto m = static_cast<double>(mass);
  return {mass, {window.x + static_cast<double>(moment_x) / m, window.y + static_cast<double>(moment_y) / m}};
}

std::optional<cv::Point2d> mean_shift(const cv::Mat &values, const ColourWeights &weights, cv::Point2d start,
                                      int side) {
  auto centre = start;
  for (int i = 0; i < max_steps; ++i) {
    const auto window = window_mass(values, weights, centre, side);
    if (window.mass == 0) return std::nullopt;
    const double step = cv::norm(window.centroid - centre);
    centre = window.centroid;
    if (step < min_step) break;
  }
  return centre;
}

}  // namespace csd
