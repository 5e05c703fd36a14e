// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <opencv2/core.hpp>

#include <array>
#include <cstdint>

#include "sim/fragments.h"
#include "sim/scenario.h"

namespace csd::sim {

/// Blood that oozes and is wiped away, water that runs over the tissue: both leave a place that looks different for
/// good. It happens at four places, one in each cycle, first from 3 s on.
class Fluids {
 public:
  Fluids(const Effects &effects, std::uint64_t seed);

  bool any() const { return blood_ > 0 || water_ > 0; }

  /// Sets the values blood, water and changed of a corner at (u, v) units.
  void wet(double time, double u, double v, Fragment &corner) const;

 private:
  struct Place {
    double u, v;
  };
  double blood_, water_;
  double radius_;
  std::array<Place, 4> places_;
  std::uint64_t seed_;
};

/// How far a value of Fluids covers a pixel, 0…1.
inline float cover(float level) {
  const float x = level + 0.5F;
  return x <= 0 ? 0 : x >= 1 ? 1 : x * x * (3 - 2 * x);
}

}  // namespace csd::sim
