// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <opencv2/core.hpp>

#include <array>
#include <cstdint>

#include "sim/cavity.h"
#include "sim/grasp.h"
#include "sim/scenario.h"
#include "sim/sheets.h"

namespace csd::sim {

inline constexpr double heart_rate = 1.25, breath_rate = 0.25;  ///< Hz, the mean: each beat and breath varies

/// The tissue's surface: a relief over texture coordinates (u, v), deformed by a mixture of Gaussians that move with
/// the heart, with breathing, and slightly at random (§3.1). Texture coordinates are in units; at rest a point lies at
/// (u, v, relief), except in a cavity.
class Surface {
 public:
  Surface(const Effects &effects, std::uint64_t seed);

  static constexpr int gaussians = 10;

  /// The time-independent properties of a place on the surface, which take long to compute.
  struct Place {
    double u = 0, v = 0;
    cv::Vec3d rest;    ///< position at rest
    cv::Vec3d normal;  ///< at rest, length 1, towards the scope; z is towards the lamp at rest
    std::array<double, gaussians> pulse{};
    double fold = 0;
    Sheets::Place cuts;
    std::uint8_t sheet = 0;  ///< number of its sheet
  };
  Place place(double u, double v) const;

  /// The surface at one moment.
  class Moment {
   public:
    /// Position of a place, units.
    cv::Vec3d at(const Place &place) const { return at(place, place.sheet); }
    /// Its position if it moved with another sheet.
    cv::Vec3d at(const Place &place, std::uint8_t sheet) const;
    /// The point behind it in a wound, as seen from the scope's initial position.
    cv::Vec3d bed(const Place &place) const;
    const Sheets::Moment &cuts() const { return cuts_; }

   private:
    friend class Surface;
    cv::Vec3d whole(const Place &place, std::uint8_t sheet) const;  // without cuts

    std::array<cv::Vec3d, gaussians> push_{};  // of each Gaussian, units
    cv::Vec3d shift_;                          // of everything
    cv::Vec3d fold_;                           // of the fold's ridge
    const Sheets *sheets_ = nullptr;           // none: no cuts
    Sheets::Moment cuts_;
    Grasp grasp_;
    bool grasped_ = false;
    std::uint8_t grasped_sheet_ = 0;
  };

  Moment at(double time) const;

  const Sheets &sheets() const { return sheets_; }
  bool hollow() const { return cavity_.any(); }
  double reach() const { return reach_; }  ///< upper bound of a point's sideways distance from its (u, v), units

 private:
  struct Bump {
    double u, v, inverse;  // inverse: 1 / 2σ²
    double height;
  };
  struct Pulse {
    double u, v, inverse;
    cv::Vec3d cardiac, breath, noise;  // units
    double lag;                        // turns of the heart's period
  };
  static constexpr int bumps = 12;

  std::array<Bump, bumps> relief_;
  std::array<Pulse, gaussians> pulses_;
  cv::Vec3d drift_;  // of everything, with breathing
  double fold_;
  Sheets sheets_;
  Cavity cavity_;
  double grasp_;
  std::uint64_t seed_;
  double reach_ = 0;
};

}  // namespace csd::sim
