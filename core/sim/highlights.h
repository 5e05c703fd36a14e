// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <cstdint>
#include <vector>

#include "sim/fragments.h"

namespace csd::sim {

/// Specular highlights of wet tissue with the lamp at the camera: where the surface, with its fine relief, faces the
/// lamp.
class Highlights {
 public:
  /// No highlights with `strength` 0.
  Highlights(double strength, std::uint64_t seed);

  struct Value {
    float core = 0;  ///< saturated share of the pixel, 0…1
    float glow = 0;  ///< light around it, 0…1
  };

  /// `slope` is the pixel's offset from the principal point over the focal length; `gloss` 0…1.
  Value at(const Fragment &f, float slope_x, float slope_y, float gloss) const;

 private:
  struct Slope {
    float x, y;
  };
  Slope relief(float u, float v) const;

  float radius_ = 0, reach_ = 0;  // in slopes of the normal: of a highlight, and of the surface near one
  std::vector<Slope> relief_;
};

}  // namespace csd::sim
