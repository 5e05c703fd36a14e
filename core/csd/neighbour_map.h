// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <opencv2/core.hpp>

#include <cstddef>
#include <limits>
#include <span>
#include <vector>

#include "csd/tuning.h"
#include "patch/affine_state.h"

namespace csd {

/// Where tissue that lies at `from` is seen now.
struct Correspondence {
  cv::Point2d from, to;

  Correspondence reversed() const { return {to, from}; }
};

/// The motion of a patch of tissue, as the points around it agree on: to = linear·from + shift.
struct NeighbourMap {
  cv::Matx22d linear = cv::Matx22d::eye();
  cv::Point2d shift;
  double spread = 0;        ///< robust scale of the points' residuals, target pixels
  std::size_t support = 0;  ///< how many points it stands on; 0: there is no map
  /// Squared distance within which as many points will be in the next frame too, most likely.
  double nearby = std::numeric_limits<double>::infinity();

  explicit operator bool() const { return support > 0; }
  cv::Point2d operator()(cv::Point2d from) const;
  cv::Point2d inverse(cv::Point2d to) const;
  double scale() const;  ///< √det linear
};

/// Fits a map to `nearest`, which is by ascending distance of `from` from `at`: weights fall off
/// with the distance, four rounds of reweighting take outliers out; from six points on an affine map that leans on the
/// similarity, a similarity below, none below three or where they lie on a point.
/// @param unit length of a pixel of the 480-line picture in the coordinates of `from`; the spread's floor is half a
/// unit
NeighbourMap fit_neighbours(std::span<const Correspondence> nearest, cv::Point2d at, double unit, const Tuning &tuning);

/// Points that are surely seen: they say how the tissue around any other point has moved.
class NeighbourField {
 public:
  static constexpr std::size_t most = 14;  ///< points to a map
  static constexpr std::size_t nobody = ~std::size_t{0};

  void clear() { points_.clear(); }
  /// `owner`: whose point it is, so that a point's own map does not stand on itself. `chart`: points of different
  /// charts have coordinates that know nothing of each other.
  void add(std::size_t owner, int chart, const Correspondence &point) { points_.push_back({point, owner, chart}); }
  /// Forgets the points of charts that have fewer than `least` of them.
  void drop_small_charts(std::size_t least);
  void keep(int chart);  ///< Forgets the points of all other charts.
  std::size_t size() const { return points_.size(); }
  std::size_t size(int chart) const;
  /// The points are seen elsewhere: where `motion` puts the place where they were.
  template <class Motion>
  void move(const Motion &motion) {
    for (auto &p : points_) p.at.to = motion(p.at.to);
  }

  /// The map about `reference`, from the nearest points by their reference coordinates. `nearby`: of the last frame's
  /// map there; it saves time, and changes nothing.
  NeighbourMap map_at(cv::Point2d reference, int chart, double unit, const Tuning &tuning, std::size_t owner = nobody,
                      double nearby = std::numeric_limits<double>::infinity()) const;
  /// The other way: from the nearest points by where they are now, a map from the picture to reference coordinates.
  NeighbourMap inverse_map_at(cv::Point2d position, int chart, double unit, const Tuning &tuning) const;

 private:
  struct Point {
    Correspondence at;
    std::size_t owner;
    int chart;
  };
  std::vector<Point> points_;
};

/// How unsure an alignment's position is: the inverse of its information, 30 px at most. px²
cv::Matx22d position_covariance(const cv::Matx22d &information);

/// What a feature has of its own beside its neighbours' motion: an offset from where they put it, and shape. In
/// reference coordinates, so that it stays the same while the view turns and zooms. Learns from frames in which the
/// feature is seen well: a fast one would take in a false lock. Neighbouring tissue moves alike, so an offset that the
/// patch is not sure of is believed only in part: without that, features on edges and in faint tissue slide.
class NeighbourOffset {
 public:
  cv::Point2d offset() const { return offset_; }
  double deviation(const Tuning &tuning) const;  ///< sd of the offset, reference pixels at 480 lines: .3 to 2
  /// State that the neighbours predict for a feature with reference coordinates `reference`.
  AffineState predict(const NeighbourMap &map, cv::Point2d reference) const;
  /// The feature begins with this shape in the map's reference coordinates.
  void begin(const cv::Matx22d &shape);
  /// @param seen where, and how surely (information, in working pixels)
  /// @param steps frames of 40 ms since the last one. @param unit as above
  void update(const NeighbourMap &map, cv::Point2d reference, const AffineState &seen, const cv::Matx22d &information,
              double steps, double unit, const Tuning &tuning);

 private:
  cv::Point2d mean_, offset_;                      ///< as seen; as believed
  cv::Matx22d covariance_ = cv::Matx22d::zeros();  ///< mean of position_covariance(), reference coordinates
  double variance_ = 4;                            ///< of the offset, in units²
  double frames_ = 1;
  cv::Matx22d shape_ = cv::Matx22d::eye();  ///< mean of map.linear⁻¹·shape
};

}  // namespace csd
