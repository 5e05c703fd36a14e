// SPDX-License-Identifier: LGPL-2.1-or-later
#include "csd2012/search.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

namespace csd {
namespace {

double falloff(const SpatialWeight &weight) {
  return std::isfinite(weight.sigma) ? 1 / (2 * weight.sigma * weight.sigma) : 0;
}

double squared_distance(cv::Point p, cv::Point2d last) {
  const double dx = p.x - last.x, dy = p.y - last.y;
  return dx * dx + dy * dy;
}

/// `probability`: CV_32FC1, of each position of the area; 0 if it is not labelled feature.
void take_best_patch(const cv::Mat &probability, const SearchArea &area, const SpatialWeight &weight,
                     SearchResult &result) {
  double best_distance = 0;
  for (const auto &p : result.matches) {
    const double distance = squared_distance(p, weight.last);
    const double here = probability.at<float>((p - area.centres.tl()) / area.step);
    const double weighted = here * std::exp(-distance * falloff(weight));
    if (result.best && weighted < result.weighted) continue;
    if (result.best && weighted == result.weighted && distance >= best_distance) continue;
    result.best = p;
    result.weighted = weighted;
    best_distance = distance;
  }
}

void take_best_cluster(const cv::Mat &probability, const SearchArea &area, const SpatialWeight &weight, int radius,
                       SearchResult &result) {
  if (result.matches.empty()) return;
  const int side = 2 * radius + 1;
  cv::Mat sums;
  cv::boxFilter(probability, sums, -1, {side, side}, {-1, -1}, false, cv::BORDER_CONSTANT);
  cv::Point middle(-1, -1);
  double best_distance = 0;
  for (int row = 0; row < sums.rows; ++row)
    for (int column = 0; column < sums.cols; ++column) {
      const double sum = sums.at<float>(row, column);
      if (sum < 1e-6) continue;
      const double distance = squared_distance(area.centres.tl() + area.step * cv::Point(column, row), weight.last);
      const double weighted = sum * std::exp(-distance * falloff(weight));
      if (weighted < result.weighted || (weighted == result.weighted && distance >= best_distance)) continue;
      middle = {column, row};
      result.weighted = weighted;
      best_distance = distance;
    }
  if (middle.x < 0) return;
  const cv::Rect square = cv::Rect(middle.x - radius, middle.y - radius, side, side) & cv::Rect({0, 0}, sums.size());
  cv::Point2d moment;
  double total = 0;
  for (int row = square.y; row < square.br().y; ++row)
    for (int column = square.x; column < square.br().x; ++column) {
      const double p = probability.at<float>(row, column);
      total += p;
      moment += p * cv::Point2d(column, row);
    }
  if (total > 0) result.best = cv::Point2d(area.centres.tl()) + area.step / total * moment;
}

}  // namespace

Reach reach_after(const csd2012::Choices &choices, std::int64_t absence, int width, int radius) {
  const double widened = std::sqrt(1 + static_cast<double>(absence) / (choices.widening * 1e9));
  return {width * choices.sigma_of_width * widened,
          static_cast<int>(std::lround(radius * std::min(widened, choices.widest_search)))};
}

SearchResult search(const Forest &descriptor, const cv::Mat &channel, cv::Point origin, const SearchArea &area,
                    const SpatialWeight &weight, const Best &wanted) {
  SearchResult result;
  const auto &centres = area.centres;
  if (centres.empty()) return result;
  cv::Mat probability;
  descriptor.scan(channel, centres - origin, area.step, probability, wanted.likeness_power);
  for (int row = 0; row < probability.rows; ++row)
    for (int column = 0; column < probability.cols; ++column)
      if (probability.at<float>(row, column) > 0)
        result.matches.push_back(centres.tl() + area.step * cv::Point(column, row));
  if (wanted.cluster_radius > 0)
    take_best_cluster(probability, area, weight, std::max(1, wanted.cluster_radius / area.step), result);
  else
    take_best_patch(probability, area, weight, result);
  if (result.weighted < wanted.min_probability) result.best.reset();
  return result;
}

}  // namespace csd
