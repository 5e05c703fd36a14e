// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <opencv2/core.hpp>

#include <array>
#include <cstdint>

#include "sim/fragments.h"
#include "sim/scenario.h"

namespace csd::sim {

/// Blood that oozes and is wiped away, and water that runs over the tissue; both permanently change the look of the
/// places they covered. There are four places, one in each quarter of the initial picture. In each cycle they bleed one
/// after another, from 3 s on; water runs over all of them from 11 s to 14.5 s; by 18 s they are clean. At strength 1
/// of both most of the picture is covered for a while, like in the paper's third occlusion sequence (§3.2.2) after 300
/// frames.
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

/// The coverage of a pixel, 0…1, from a value of Fluids.
inline float cover(float level) {
  const float x = level + 0.5F;
  return x <= 0 ? 0 : x >= 1 ? 1 : x * x * (3 - 2 * x);
}

}  // namespace csd::sim
