// SPDX-License-Identifier: LGPL-2.1-or-later
#include "score/stir.h"

namespace csd::score {

JaccardSums stir_2026_sums(const Clip &clip) {
  JaccardSums sums;
  for (std::size_t f = 0; f < clip.ids.size(); ++f)
    for (std::size_t t = 1; t < clip.moments.size(); ++t) {
      const Sample &sample = clip.at(f, t);
      if (sample.labelled()) sums.add(sample, sample.distance(), stir_2026_pixels);
    }
  return sums;
}

std::vector<double> end_distances(const Clip &clip, std::span<const cv::Point2d> points) {
  std::vector<double> distances;
  if (clip.ends.empty()) return distances;
  for (const cv::Point2d &point : points) {
    double nearest = std::numeric_limits<double>::infinity();
    for (const cv::Point2d &end : clip.ends) nearest = std::min(nearest, std::hypot(point.x - end.x, point.y - end.y));
    distances.push_back(nearest);
  }
  return distances;
}

Stir2024Score stir_2024_score(std::span<const double> distances) {
  Stir2024Score score;
  if (distances.empty()) return score;
  score.delta_avg = 0;
  for (std::size_t i = 0; i < jaccard_thresholds; ++i) {
    const auto near =
        std::count_if(distances.begin(), distances.end(), [&](double d) { return d <= stir_2024_pixels[i]; });
    score.within[i] = static_cast<double>(near) / static_cast<double>(distances.size());
    score.delta_avg += score.within[i] / jaccard_thresholds;
  }
  return score;
}

}  // namespace csd::score
