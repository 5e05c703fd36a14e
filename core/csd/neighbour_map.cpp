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

NeighbourMap map_by(const Similarity &s) {
  NeighbourMap map;
  map.linear = {s.a, -s.b, s.b, s.a};
  map.shift = s.shift;
  return map;
}

/// One weighted least-squares fit. Affine: L = S + (D − S·C)(C + λI)⁻¹, with the similarity S and the ridge λ. False if
/// the points coincide.
bool fit(std::span<const Correspondence> points, const double *weights, bool affine, double ridge, NeighbourMap &map) {
  const auto m = PointMoments::of(points, weights);
  if (m.degenerate()) return false;
  const auto s = fit_similarity(m);
  double l00 = s.a, l01 = -s.b, l10 = s.b, l11 = s.a;
  if (affine) {
    const double e00 = m.dxx - (s.a * m.cxx - s.b * m.cxy), e01 = m.dxy - (s.a * m.cxy - s.b * m.cyy);
    const double e10 = m.dyx - (s.b * m.cxx + s.a * m.cxy), e11 = m.dyy - (s.b * m.cxy + s.a * m.cyy);
    const double p = m.cxx + ridge, q = m.cyy + ridge, det = p * q - m.cxy * m.cxy;
    l00 += (e00 * q - e01 * m.cxy) / det;
    l01 += (e01 * p - e00 * m.cxy) / det;
    l10 += (e10 * q - e11 * m.cxy) / det;
    l11 += (e11 * p - e10 * m.cxy) / det;
  }
  if (!(l00 * l11 - l01 * l10 > 1e-6)) return false;
  map.linear = {l00, l01, l10, l11};
  map.shift = {m.to.x - (l00 * m.from.x + l01 * m.from.y), m.to.y - (l10 * m.from.x + l11 * m.from.y)};
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

namespace {

/// Up to 14 points, weighted by their distance from a place, and robust fits to them.
class Neighbours {
 public:
  Neighbours(std::span<const Correspondence> nearest, cv::Point2d at, double unit, const Tuning &tuning)
      : points_(nearest.first(std::min(nearest.size(), NeighbourField::most))), unit_(unit), tuning_(tuning) {
    const double fifth = std::sqrt(squared(points_[std::min<std::size_t>(points_.size() - 1, 4)].from - at));
    const double reach = std::max(tuning.min_reach * unit, tuning.reach_per_fifth * fifth);
    for (std::size_t i = 0; i < points_.size(); ++i)
      near_[i] = std::exp(-squared(points_[i].from - at) / (2 * reach * reach)) + tuning.floor_weight;
  }

  /// The motion of most points. Its spread is set even where it exceeds max_spread and the result is no map.
  NeighbourMap common() {
    weights_ = near_;
    auto map = fit_robustly(points_.size(), std::numeric_limits<double>::infinity());
    if (!(map.spread <= tuning_.max_spread * unit_)) map.support = 0;
    return map;
  }

  /// The motion of the piece of tissue to which the place belongs, if that explains the points clearly better than
  /// `common` does; else no map. Each pair of the nearest points proposes a similarity.
  /// @param own the point's own alignment, which may be missing: it also votes
  NeighbourMap piece(const NeighbourMap &common, const Correspondence *own) {
    double least = tuning_.piece_gain * cost(common, own);
    NeighbourMap best;
    const auto pairs = std::min(points_.size(), count(tuning_.piece_pairs));
    for (std::size_t i = 0; i < pairs; ++i)
      for (std::size_t j = i + 1; j < pairs; ++j) {
        if (squared(points_[i].from - points_[j].from) < square(tuning_.piece_base * unit_)) continue;
        const auto motion = similarity_through(points_[i], points_[j]);
        if (!motion.zooms_at_most(tuning_.max_zoom)) continue;
        const auto proposal = map_by(motion);
        const double found = cost(proposal, own);
        if (found >= least) continue;
        least = found;
        best = proposal;
        best.support = 2;
      }
    if (!best) return best;
    measure(best);
    const double spread = tuning_.piece_spread * unit_;
    weigh(spread);
    return fit_robustly(agreeing(spread), spread);
  }

 private:
  static double residual(const NeighbourMap &map, const Correspondence &point) {
    return squared(map(point.from) - point.to);
  }

  /// Fits and reweights in turn.
  /// @param agree how many points agree with the weights' map. @param max_spread of those that do: spread and support
  /// are theirs
  NeighbourMap fit_robustly(std::size_t agree, double max_spread) {
    NeighbourMap map;
    for (int round = 0;; ++round) {
      if (agree < min_points || !fit(points_, weights_.data(), agree >= min_affine, tuning_.ridge * unit_ * unit_, map))
        return {};
      if (round == rounds) break;
      measure(map);
      agree = agreeing(max_spread);
      if (agree < min_points) return {};
      const auto middle = ordered_.begin() + static_cast<std::ptrdiff_t>(agree / 2);
      std::nth_element(ordered_.begin(), middle, ordered_.begin() + static_cast<std::ptrdiff_t>(agree));
      map.spread =
          std::max(tuning_.min_spread * unit_, std::min(max_spread, tuning_.spread_per_median * std::sqrt(*middle)));
      if (weigh(map.spread) < tuning_.settled) break;
    }
    map.support = agree;
    return map;
  }

  void measure(const NeighbourMap &map) {
    for (std::size_t i = 0; i < points_.size(); ++i) residual_[i] = residual(map, points_[i]);
  }

  /// Puts the residuals of the points that agree into ordered_, and returns their number.
  std::size_t agreeing(double spread) {
    const double limit = square(tuning_.outlier * spread);
    const auto end = std::copy_if(residual_.begin(), residual_.begin() + static_cast<std::ptrdiff_t>(points_.size()),
                                  ordered_.begin(), [=](double r) { return r < limit; });
    return static_cast<std::size_t>(end - ordered_.begin());
  }

  /// Sets the weights by the residuals; returns the largest change.
  double weigh(double spread) {
    const double scale = 1 / square(tuning_.outlier * spread);
    double change = 0;
    for (std::size_t i = 0; i < points_.size(); ++i) {
      const double weight = near_[i] / square(1 + residual_[i] * scale);
      change = std::max(change, std::abs(weight - weights_[i]));
      weights_[i] = weight;
    }
    return change;
  }

  /// Geman and McClure's robust cost.
  double cost(const NeighbourMap &map, const Correspondence *own) const {
    const double soft = square(tuning_.piece_spread * unit_);
    const auto robust = [&](const Correspondence &point) {
      const double r = residual(map, point);
      return r / (r + soft);
    };
    double sum = own ? tuning_.own_vote * robust(*own) : 0;
    for (std::size_t i = 0; i < points_.size(); ++i) sum += near_[i] * robust(points_[i]);
    return sum;
  }

  std::span<const Correspondence> points_;
  double unit_;
  const Tuning &tuning_;
  std::array<double, NeighbourField::most> near_{}, weights_{}, residual_{}, ordered_{};  // residuals: squared
};

}  // namespace

NeighbourMap fit_neighbours(std::span<const Correspondence> nearest, cv::Point2d at, double unit, const Tuning &tuning,
                            const Correspondence *own) {
  if (nearest.size() < min_points) return {};
  Neighbours neighbours(nearest, at, unit, tuning);
  const auto common = neighbours.common();
  if (nearest.size() < min_affine || common.spread <= tuning.common_spread * unit) return common;
  const auto piece = neighbours.piece(common, own);
  return piece.support >= count(tuning.min_piece) ? piece : common;
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
                         Distance distance, Turn turn, const Correspondence *own = nullptr) {
  Nearest best;
  auto found = find_nearest(n, nearby, distance, best);
  if (found < best.size() && !std::isinf(nearby))
    found = find_nearest(n, std::numeric_limits<double>::infinity(), distance, best);
  std::array<Correspondence, NeighbourField::most> nearest;
  for (std::size_t k = 0; k < found; ++k) nearest[k] = turn(best[k].second);
  auto map = fit_neighbours({nearest.data(), found}, at, unit, tuning, own);
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
                                    std::size_t owner, double nearby, const Correspondence *own) const {
  return fit_nearest(
      points_.size(), reference, unit, tuning, nearby,
      [&](std::size_t i) {
        const auto &p = points_[i];
        return p.owner == owner || p.chart != chart ? -1 : squared(p.at.from - reference);
      },
      [&](std::size_t i) { return points_[i].at; }, own);
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
