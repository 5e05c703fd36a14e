// SPDX-License-Identifier: LGPL-2.1-or-later
#include "track/search.h"

#include <cmath>

namespace csd {

SearchResult search(const Tree &descriptor, const cv::Mat &channel, cv::Point origin, const cv::Rect &centres,
                    cv::Point2d last, double sigma) {
  SearchResult result;
  if (centres.empty()) return result;
  std::vector<std::int32_t> leaves;
  descriptor.scan(channel, centres - origin, leaves);
  const double falloff = std::isfinite(sigma) ? 1 / (2 * sigma * sigma) : 0;
  double best_distance = 0;
  std::size_t i = 0;
  for (int y = centres.y; y < centres.y + centres.height; ++y)
    for (int x = centres.x; x < centres.x + centres.width; ++x, ++i) {
      if (!descriptor.is_feature(leaves[i])) continue;
      const cv::Point p(x, y);
      result.matches.push_back(p);
      const double dx = x - last.x, dy = y - last.y, distance = dx * dx + dy * dy;
      const double weighted = descriptor.probability(leaves[i]) * std::exp(-distance * falloff);
      if (!result.best || weighted > result.weighted || (weighted == result.weighted && distance < best_distance)) {
        result.best = p;
        result.weighted = weighted;
        best_distance = distance;
      }
    }
  return result;
}

}  // namespace csd
