// SPDX-License-Identifier: LGPL-2.1-or-later
#include "csd/neighbour_map.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace csd {
namespace {

constexpr int rounds = 5;                              // of reweighting
constexpr std::size_t min_points = 3, min_affine = 6;  // of a similarity, of an affine map

double square(double x) {
  return x * x;
}
double squared(cv::Point2d p) {
  return p.dot(p);
}

/// One weighted least-squares fit about the weighted means. False if the points coincide.
bool fit(std::span<const Correspondence> points, const double *weights, bool affine, double ridge_weight,
         NeighbourMap &map) {
  double sum = 0;
  cv::Point2d from, to;
  for (std::size_t i = 0; i < points.size(); ++i) {
    sum += weights[i];
    from += weights[i] * points[i].from;
    to += weights[i] * points[i].to;
  }
  from /= sum;
  to /= sum;
  // C = Σ w x xᵀ and D = Σ w y xᵀ about the means.
  double cxx = 0, cxy = 0, cyy = 0, dxx = 0, dxy = 0, dyx = 0, dyy = 0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const auto x = points[i].from - from, y = points[i].to - to;
    const auto w = weights[i];
    cxx += w * x.x * x.x;
    cxy += w * x.x * x.y;
    cyy += w * x.y * x.y;
    dxx += w * y.x * x.x;
    dxy += w * y.x * x.y;
    dyx += w * y.y * x.x;
    dyy += w * y.y * x.y;
  }
  const double trace = cxx + cyy;
  if (!(trace > 1e-9 * sum)) return false;
  const double a = (dxx + dyy) / trace, b = (dyx - dxy) / trace;
  double l00 = a, l01 = -b, l10 = b, l11 = a;
  if (affine) {
    // L = S + (D − S·C)(C + λI)⁻¹
    const double e00 = dxx - (a * cxx - b * cxy), e01 = dxy - (a * cxy - b * cyy);
    const double e10 = dyx - (b * cxx + a * cxy), e11 = dyy - (b * cxy + a * cyy);
    const double p = cxx + ridge_weight, q = cyy + ridge_weight, det = p * q - cxy * cxy;
    l00 += (e00 * q - e01 * cxy) / det;
    l01 += (e01 * p - e00 * cxy) / det;
    l10 += (e10 * q - e11 * cxy) / det;
    l11 += (e11 * p - e10 * cxy) / det;
  }
  if (!(l00 * l11 - l01 * l10 > 1e-6)) return false;
  map.linear = {l00, l01, l10, l11};
  map.shift = {to.x - (l00 * from.x + l01 * from.y), to.y - (l10 * from.x + l11 * from.y)};
  return true;
}

}  // namespace

cv::Point2d NeighbourMap::operator()(cv::Point2d from) const {
  return {linear(0, 0) * from.x + linear(0, 1) * from.y + shift.x,
          linear(1, 0) * from.x + linear(1, 1) * from.y + shift.y};
}

cv::Point2d NeighbourMap::inverse(cv::Point2d to) const {
  const auto p = to - shift;
  const double det = linear(0, 0) * linear(1, 1) - linear(0, 1) * linear(1, 0);
  return {(linear(1, 1) * p.x - linear(0, 1) * p.y) / det, (linear(0, 0) * p.y - linear(1, 0) * p.x) / det};
}

double NeighbourMap::scale() const {
  return std::sqrt(linear(0, 0) * linear(1, 1) - linear(0, 1) * linear(1, 0));
}

NeighbourMap fit_neighbours(std::span<const Correspondence> nearest, cv::Point2d at, double unit,
                            const Tuning &tuning) {
  NeighbourMap map;
  if (nearest.size() < min_points) return map;
  std::array<double, NeighbourField::most> near{}, weights{};
  const auto n = std::min(nearest.size(), near.size());
  const auto points = nearest.first(n);
  const double fifth = std::sqrt(squared(points[std::min<std::size_t>(n - 1, 4)].from - at));
  const double reach = std::max(tuning.min_reach * unit, tuning.reach_per_fifth * fifth);
  for (std::size_t i = 0; i < n; ++i)
    weights[i] = near[i] = std::exp(-squared(points[i].from - at) / (2 * reach * reach)) + tuning.floor_weight;

  std::array<double, NeighbourField::most> residual{}, ordered{};
  for (int round = 0; round <= rounds; ++round) {
    if (!fit(points, weights.data(), n >= min_affine, tuning.ridge * unit * unit, map)) return map;
    if (round == rounds) break;
    for (std::size_t i = 0; i < n; ++i) residual[i] = squared(map(points[i].from) - points[i].to);
    std::copy_n(residual.begin(), n, ordered.begin());
    const auto middle = ordered.begin() + static_cast<std::ptrdiff_t>(n / 2);
    std::nth_element(ordered.begin(), middle, ordered.begin() + static_cast<std::ptrdiff_t>(n));
    map.spread = std::max(tuning.min_spread * unit, tuning.spread_per_median * std::sqrt(*middle));
    const double scale = 1 / square(tuning.outlier * map.spread);
    double change = 0;
    for (std::size_t i = 0; i < n; ++i) {
      const double weight = near[i] / square(1 + residual[i] * scale);
      change = std::max(change, std::abs(weight - weights[i]));
      weights[i] = weight;
    }
    if (change < tuning.settled) break;
  }
  if (map.spread <= tuning.max_spread * unit) map.support = n;
  return map;
}

namespace {

using Nearest = std::array<std::pair<double, std::size_t>, NeighbourField::most>;  // squared distance, index

/// Finds the nearest points within `nearby`, by ascending distance, and returns their number. `distance` returns the
/// squared distance of a point, negative if it is excluded.
template <class Distance>
std::size_t find_nearest(std::size_t n, double nearby, Distance distance, Nearest &best) {
  std::size_t found = 0;
  for (std::size_t i = 0; i < n; ++i) {
    const double d = distance(i);
    if (d < 0 || d > nearby || (found == best.size() && d >= best.back().first)) continue;
    // Insertion is faster than sorting, because most points are farther.
    std::size_t k = found < best.size() ? found++ : found - 1;
    for (; k > 0 && best[k - 1].first > d; --k) best[k] = best[k - 1];
    best[k] = {d, i};
  }
  return found;
}

template <class Distance, class Turn>
NeighbourMap fit_nearest(std::size_t n, cv::Point2d at, double unit, const Tuning &tuning, double nearby,
                         Distance distance, Turn turn) {
  Nearest best;
  auto found = find_nearest(n, nearby, distance, best);
  if (found < best.size() && !std::isinf(nearby))
    found = find_nearest(n, std::numeric_limits<double>::infinity(), distance, best);
  std::array<Correspondence, NeighbourField::most> nearest;
  for (std::size_t k = 0; k < found; ++k) nearest[k] = turn(best[k].second);
  auto map = fit_neighbours({nearest.data(), found}, at, unit, tuning);
  if (found == best.size()) map.nearby = tuning.nearby_margin * best.back().first;
  return map;
}

}  // namespace

void NeighbourField::drop_small_charts(std::size_t least) {
  std::vector<std::pair<int, std::size_t>> charts;  // one or two
  for (const auto &p : points_) {
    auto c = std::find_if(charts.begin(), charts.end(), [&](const auto &chart) { return chart.first == p.chart; });
    if (c == charts.end()) c = charts.insert(c, {p.chart, 0});
    ++c->second;
  }
  for (const auto &[chart, size] : charts)
    if (size < least) std::erase_if(points_, [c = chart](const Point &p) { return p.chart == c; });
}

void NeighbourField::keep(int chart) {
  std::erase_if(points_, [chart](const Point &p) { return p.chart != chart; });
}

std::size_t NeighbourField::size(int chart) const {
  return static_cast<std::size_t>(
      std::count_if(points_.begin(), points_.end(), [chart](const Point &p) { return p.chart == chart; }));
}

NeighbourMap NeighbourField::map_at(cv::Point2d reference, int chart, double unit, const Tuning &tuning,
                                    std::size_t owner, double nearby) const {
  return fit_nearest(
      points_.size(), reference, unit, tuning, nearby,
      [&](std::size_t i) {
        const auto &p = points_[i];
        return p.owner == owner || p.chart != chart ? -1 : squared(p.at.from - reference);
      },
      [&](std::size_t i) { return points_[i].at; });
}

NeighbourMap NeighbourField::inverse_map_at(cv::Point2d position, int chart, double unit, const Tuning &tuning) const {
  return fit_nearest(
      points_.size(), position, unit, tuning, std::numeric_limits<double>::infinity(),
      [&](std::size_t i) { return points_[i].chart != chart ? -1 : squared(points_[i].at.to - position); },
      [&](std::size_t i) { return points_[i].at.reversed(); });
}

cv::Matx22d position_covariance(const cv::Matx22d &information) {
  return (information + 1e-3 * cv::Matx22d::eye()).inv();
}

double NeighbourOffset::deviation(const Tuning &tuning) const {
  return std::clamp(std::sqrt(variance_), tuning.min_deviation, tuning.max_deviation);
}

AffineState NeighbourOffset::predict(const NeighbourMap &map, cv::Point2d reference) const {
  return {map(reference + offset_), map.linear * shape_};
}

void NeighbourOffset::begin(const cv::Matx22d &shape) {
  *this = {};
  shape_ = shape;
}

void NeighbourOffset::update(const NeighbourMap &map, cv::Point2d reference, const AffineState &seen,
                             const cv::Matx22d &information, double steps, double unit, const Tuning &tuning) {
  const double rate = std::min(1.0, std::max(tuning.slowest * steps, 1 / (frames_ + 1)));
  const auto difference = map.inverse(seen.position) - reference - mean_;
  const double clipped = std::min(squared(difference) / (unit * unit), 9 * square(deviation(tuning)) + 4);
  variance_ += rate * (clipped - variance_);
  mean_ += rate * difference;
  const auto back = map.linear.inv();
  covariance_ += rate * (back * position_covariance(information) * back.t() - covariance_);
  const double prior = square(tuning.usual_offset * unit);
  offset_ = (covariance_ + prior * cv::Matx22d::eye()).inv() * mean_ * prior;
  if (const double size = std::sqrt(squared(offset_)); size > tuning.max_offset * unit)
    offset_ *= tuning.max_offset * unit / size;
  shape_ += rate * (back * seen.shape - shape_);
  ++frames_;
}

}  // namespace csd
