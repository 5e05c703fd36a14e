// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <opencv2/core.hpp>

#include <array>
#include <cstdint>

#include "sim/scenario.h"

namespace csd::sim {

/// The tissue's surface: a relief over texture coordinates (u, v), deformed by a mixture of Gaussians that move with
/// the heart and with breathing, and a little at random (§3.1). Texture coordinates are units; at rest a point lies at
/// (u, v, relief).
class Surface {
 public:
  Surface(const Effects &effects, std::uint64_t seed);

  /// The surface at one moment: a cheap copy of what depends on time.
  class Moment {
   public:
    /// Where the point (u, v) is, units.
    cv::Vec3d at(double u, double v) const;

   private:
    friend class Surface;
    explicit Moment(const Surface &surface) : surface_(&surface) {}

    static constexpr int gaussians = 10;
    const Surface *surface_;
    std::array<cv::Vec3d, gaussians> push_{};  // of each Gaussian, units
    cv::Vec3d shift_;                          // of everything
    double fold_height_ = 0, fold_lean_ = 0;
  };

  Moment at(double time) const;

  /// Normal of the surface at rest, length 1, towards the scope.
  cv::Vec3d rest_normal(double u, double v) const;

  double lowest() const { return -130; }   ///< nothing is ever below this, units
  double reach() const { return reach_; }  ///< no point is ever farther than this from its (u, v), units, sideways

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
  std::array<Pulse, Moment::gaussians> pulses_;
  cv::Vec3d drift_;  // of everything, with breathing
  double fold_;
  std::uint64_t seed_;
  double reach_ = 0;
};

}  // namespace csd::sim
