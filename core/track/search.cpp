// SPDX-License-Identifier: LGPL-2.1-or-later
#include "track/search.h"

#include <algorithm>
#include <cmath>

#include "track/csd2012_choices.h"

namespace csd {

using namespace csd2012;

Reach reach_after(std::int64_t absence, bool anywhere, int width, int radius) {
  if (anywhere) return {std::numeric_limits<double>::infinity(), radius};
  const double widened = std::sqrt(1 + static_cast<double>(absence) / widening);
  return {width * sigma_of_width * widened, static_cast<int>(std::lround(radius * std::min(widened, widest_search)))};
}

SearchResult search(const Tree &descriptor, const cv::Mat &channel, cv::Point origin, const SearchArea &area,
                    const SpatialWeight &weight) {
  SearchResult result;
  const auto &centres = area.centres;
  if (centres.empty()) return result;
  std::vector<std::int32_t> leaves;
  descriptor.scan(channel, centres - origin, leaves, area.step);
  const double falloff = std::isfinite(weight.sigma) ? 1 / (2 * weight.sigma * weight.sigma) : 0;
  double best_distance = 0;
  std::size_t i = 0;
  for (int y = centres.y; y < centres.y + centres.height; y += area.step)
    for (int x = centres.x; x < centres.x + centres.width; x += area.step, ++i) {
      if (!descriptor.is_feature(leaves[i])) continue;
      const cv::Point p(x, y);
      result.matches.push_back(p);
      const double dx = x - weight.last.x, dy = y - weight.last.y, distance = dx * dx + dy * dy;
      const double weighted = descriptor.probability(leaves[i]) * std::exp(-distance * falloff);
      if (!result.best || weighted > result.weighted || (weighted == result.weighted && distance < best_distance)) {
        result.best = p;
        result.weighted = weighted;
        best_distance = distance;
      }
    }
  return result;
}

SearchResult search_coarse_to_fine(const Tree &descriptor, const cv::Mat &channel, cv::Point origin,
                                   const SearchArea &area, const SpatialWeight &weight) {
  auto result = search(descriptor, channel, origin, area, weight);
  if (!result.best || area.step == 1) return result;
  const int reach = area.step - 1, side = 2 * reach + 1;
  const cv::Rect around = cv::Rect(result.best->x - reach, result.best->y - reach, side, side) & area.centres;
  const auto fine = search(descriptor, channel, origin, {around, 1}, weight);
  result.best = fine.best;
  result.weighted = fine.weighted;
  return result;
}

}  // namespace csd
