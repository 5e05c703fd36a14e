// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <opencv2/core.hpp>

#include <cstdint>

#include "sim/scenario.h"

namespace csd::sim {

/// Lines along which the tissue is not one: with the effect slide one sheet lies over another and slides on it, with
/// tear a cut opens. Each point (u, v) belongs to one sheet, and a sheet moves as a whole: beyond its edge it goes on
/// as if it ended nowhere, so that a mesh over the edge is smooth.
class Sheets {
 public:
  Sheets(const Effects &effects, std::uint64_t seed);

  // Bits of a sheet's number; each is 0 without its effect.
  static constexpr std::uint8_t upper = 1;       ///< lies over the other
  static constexpr std::uint8_t second_lip = 2;  ///< is on that side of the cut
  /// The upper sheet is drawn so much nearer (units) than it is: it hides the other whatever their reliefs.
  static constexpr double hides = 80;
  static constexpr int bed = -1;  ///< what a cut bares: other tissue, which no point belongs to

  bool any() const { return slide_ > 0 || gape_ > 0; }
  /// Calls `visit` with the number of each sheet that there is.
  template <class Visit>
  void each(Visit visit) const {
    for (std::uint8_t sheet = 0; sheet < 4; ++sheet)
      if ((slide_ > 0 || (sheet & upper) == 0) && (gape_ > 0 || (sheet & second_lip) == 0)) visit(sheet);
  }

  /// Where a place lies; lengths in units.
  struct Place {
    double along = 0;    ///< the upper sheet's edge
    double inside = -1;  ///< how far inside the upper sheet; negative: so far outside
    double beside = -1;  ///< from the cut, positive on the second lip's side
    double within = -9;  ///< how far within the cut's ends: 1 in its middle, 0 at the ends, negative beyond
    double lens = 0;     ///< how far the cut opens here at most, 0…1
  };
  Place place(double u, double v) const;
  static std::uint8_t sheet_of(const Place &p) {
    return static_cast<std::uint8_t>((p.inside > 0 ? upper : 0) | (p.beside > 0 ? second_lip : 0));
  }

  /// The sheets at one moment; from rest at time 0.
  struct Moment {
    cv::Vec3d slid;    ///< of the upper sheet, units
    double along = 0;  ///< of it along its edge
    double over = 0;   ///< how far it lies over the other
    double gape = 0;   ///< half the opening in the cut's middle
    cv::Vec3d apart;   ///< which way the second lip goes
    bool has_upper = false;
  };
  Moment at(double time) const;

  /// What is added to a place that moves with `sheet`.
  cv::Vec3d shift(const Moment &moment, const Place &place, std::uint8_t sheet) const;
  /// What is added to the bed behind a place: it goes along with the sheet that is cut.
  static cv::Vec3d bed_shift(const Moment &moment, const Place &place) {
    return place.inside > 0 ? moment.slid : cv::Vec3d(0, 0, 0);
  }
  /// Whether the bed may be seen there, also where the tissue folds.
  static bool bared(const Moment &moment, const Place &place);

  /// What the sheets do to the light on a place of `sheet`, or of the bed: a shadow beside the upper sheet, its edge,
  /// the edges of a wound and its depth.
  double shade(const Moment &moment, const Place &place, int sheet) const;

  double reach() const;  ///< no point is moved farther sideways, units

 private:
  double slide_, gape_ = 0;  // half the opening, units
  cv::Point2d edge_, cut_;   // a point of each line
  cv::Point2d edge_along_, cut_along_;
};

}  // namespace csd::sim
