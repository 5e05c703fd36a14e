// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <opencv2/core.hpp>

#include <cstddef>
#include <limits>
#include <span>
#include <vector>

#include "csd/similarity.h"
#include "csd/tuning.h"
#include "patch/affine_state.h"

namespace csd {

/// The local motion of the tissue, estimated from nearby points: to = linear·from + shift.
struct NeighbourMap {
  cv::Matx22d linear = cv::Matx22d::eye();
  cv::Point2d shift;
  double spread = 0;        ///< robust scale of the residuals, target pixels
  std::size_t support = 0;  ///< number of points used; 0: no map
  /// Squared radius that should still hold as many points in the next frame.
  double nearby = std::numeric_limits<double>::infinity();

  explicit operator bool() const { return support > 0; }
  cv::Point2d operator()(cv::Point2d from) const;
  cv::Point2d inverse(cv::Point2d to) const;
  double scale() const;  ///< √det linear
};

/// Fits a map to `nearest`, sorted by ascending distance of `from` from `at`. Weights decrease with distance; up to
/// five rounds of reweighting suppress outliers. Six or more points give an affine map, regularised towards the
/// similarity; three to five give a similarity. Fewer points, or coincident ones, give no map.
/// Where tissue moves in pieces (it is cut, grasped, or slides; tools move), one motion does not suit all points. Then
/// the map is that of the piece to which most of the nearest belong. No map if neither all nor a piece agree.
/// @param unit length of a pixel of the 480-line picture in the coordinates of `from`; the spread is at least half a
/// unit
/// @param own where the point at `at` itself was aligned, if that is known: decides between pieces that are about equal
NeighbourMap fit_neighbours(std::span<const Correspondence> nearest, cv::Point2d at, double unit, const Tuning &tuning,
                            const Correspondence *own = nullptr);

/// The reliable supporting points: they predict the motion of the tissue around any other point.
class NeighbourField {
 public:
  static constexpr std::size_t most = 14;  ///< points per map
  static constexpr std::size_t nobody = ~std::size_t{0};

  void clear() { points_.clear(); }
  /// `owner`: whose point it is, so that its own map excludes it. `chart`: coordinates of different charts are
  /// unrelated.
  void add(std::size_t owner, int chart, const Correspondence &point) { points_.push_back({point, owner, chart}); }
  /// Drops the points of charts that have fewer than `least` of them.
  void drop_small_charts(std::size_t least);
  void keep(int chart);  ///< Drops the points of all other charts.
  std::size_t size() const { return points_.size(); }
  std::size_t size(int chart) const;
  /// Moves the points' current positions by `motion`.
  template <class Motion>
  void move(const Motion &motion) {
    for (auto &p : points_) p.at.to = motion(p.at.to);
  }

  /// The map at `reference`, from the nearest points in reference coordinates. `nearby`: from the last frame's map
  /// there; it saves time without changing the result. `own`: as in fit_neighbours().
  NeighbourMap map_at(cv::Point2d reference, int chart, double unit, const Tuning &tuning, std::size_t owner = nobody,
                      double nearby = std::numeric_limits<double>::infinity(),
                      const Correspondence *own = nullptr) const;
  /// The inverse: a map from the picture to reference coordinates, from the points nearest in the picture.
  NeighbourMap inverse_map_at(cv::Point2d position, int chart, double unit, const Tuning &tuning) const;

 private:
  struct Point {
    Correspondence at;
    std::size_t owner;
    int chart;
  };
  std::vector<Point> points_;
};

/// Covariance of an aligned position, px²: the inverse of its information, sd at most 32 px.
cv::Matx22d position_covariance(const cv::Matx22d &information);

/// A feature's own deviation from the neighbours' map: an offset from the predicted position, and a shape. In reference
/// coordinates, so it stays constant while the view turns and zooms. Updated slowly and from good alignments only: fast
/// updates would adopt a false match. Neighbouring tissue moves alike, so an offset with a large covariance is shrunk:
/// otherwise features on edges and in faint tissue slide.
class NeighbourOffset {
 public:
  cv::Point2d offset() const { return offset_; }
  double deviation(const Tuning &tuning) const;  ///< sd of the offset, reference pixels at 480 lines: .3 to 2
  /// The state that the map predicts for a feature with reference coordinates `reference`.
  AffineState predict(const NeighbourMap &map, cv::Point2d reference) const;
  /// Starts the feature with this shape in the map's reference coordinates.
  void begin(const cv::Matx22d &shape);
  /// @param seen aligned state. @param information of its position, working pixels
  /// @param steps frames of 40 ms since the last one. @param unit as above
  void update(const NeighbourMap &map, cv::Point2d reference, const AffineState &seen, const cv::Matx22d &information,
              double steps, double unit, const Tuning &tuning);

 private:
  cv::Point2d mean_, offset_;                      ///< measured; shrunk by its covariance
  cv::Matx22d covariance_ = cv::Matx22d::zeros();  ///< mean of position_covariance(), reference coordinates
  double variance_ = 4;                            ///< of the offset, in units²
  double frames_ = 1;
  cv::Matx22d shape_ = cv::Matx22d::eye();  ///< mean of map.linear⁻¹·shape
};

}  // namespace csd
