// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <opencv2/core.hpp>

#include <cstdint>

#include "sim/scenario.h"

namespace csd::sim {

/// Discontinuities of the tissue: with the effect slide one sheet lies over another and slides on it, with tear a cut
/// opens. Each point (u, v) belongs to one sheet, and a sheet moves as a whole: its motion is defined beyond its edge
/// too, so that a mesh across the edge is smooth.
class Sheets {
 public:
  Sheets(const Effects &effects, std::uint64_t seed);

  // Bits of a sheet's number, each 0 without its effect.
  static constexpr std::uint8_t upper = 1;       ///< lies over the other
  static constexpr std::uint8_t second_lip = 2;  ///< lies on that side of the cut
  /// The upper sheet is drawn this much nearer (units) than it is, so that it hides the other whatever their reliefs.
  static constexpr double hides = 80;
  static constexpr int bed = -1;  ///< the tissue exposed by a cut, which no point belongs to

  bool any() const { return slide_ > 0 || gape_ > 0; }
  /// Calls `visit` with the number of each sheet.
  template <class Visit>
  void each(Visit visit) const {
    for (std::uint8_t sheet = 0; sheet < 4; ++sheet)
      if ((slide_ > 0 || (sheet & upper) == 0) && (gape_ > 0 || (sheet & second_lip) == 0)) visit(sheet);
  }

  /// A place relative to the sheets; lengths in units.
  struct Place {
    double along = 0;    ///< along the upper sheet's edge
    double inside = -1;  ///< distance inside the upper sheet; negative: outside
    double beside = -1;  ///< from the cut, positive on the second lip's side
    double within = -9;  ///< position between the cut's ends: 1 in its middle, 0 at the ends, negative beyond
    double lens = 0;     ///< the cut's maximum opening here, 0…1
  };
  Place place(double u, double v) const;
  static std::uint8_t sheet_of(const Place &p) {
    return static_cast<std::uint8_t>((p.inside > 0 ? upper : 0) | (p.beside > 0 ? second_lip : 0));
  }

  /// The sheets at one moment; at rest at time 0.
  struct Moment {
    cv::Vec3d slid;    ///< of the upper sheet, units
    double along = 0;  ///< its part along the edge
    double over = 0;   ///< overlap with the other sheet
    double gape = 0;   ///< half the opening in the cut's middle
    cv::Vec3d apart;   ///< direction in which the second lip moves
    bool has_upper = false;
  };
  Moment at(double time) const;

  /// The displacement of a place that moves with `sheet`.
  cv::Vec3d shift(const Moment &moment, const Place &place, std::uint8_t sheet) const;
  /// The displacement of the bed behind a place: it moves with the cut sheet.
  static cv::Vec3d bed_shift(const Moment &moment, const Place &place) {
    return place.inside > 0 ? moment.slid : cv::Vec3d(0, 0, 0);
  }
  /// Whether the bed may be visible there, even where the tissue folds.
  static bool bared(const Moment &moment, const Place &place);

  /// The brightness factor of a place on `sheet`, or on the bed: the shadow beside the upper sheet, its edge, and the
  /// edges and depth of a wound.
  double shade(const Moment &moment, const Place &place, int sheet) const;

  double reach() const;  ///< upper bound of a point's sideways displacement, units

 private:
  double slide_, gape_ = 0;  // half the opening, units
  cv::Point2d edge_, cut_;   // a point of each line
  cv::Point2d edge_along_, cut_along_;
};

}  // namespace csd::sim
