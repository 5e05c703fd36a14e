// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <cstdint>

#include "sim/noise_field.h"

namespace csd::sim {

struct VesselOptions {
  int trees = 10;
  double width = 4;     ///< of a trunk, samples
  double least = 0.8;   ///< width at which branches end, samples
  double length = 500;  ///< of a trunk, samples; branches are shorter
  double wind = 0.02;   ///< curvature, turns per ten samples
  double branches = 3;  ///< per vessel
};

/// Draws trees of vessels into a field: the larger of the old value and the vessel's, 1 in its middle, 0 at its edge.
void draw_vessels(NoiseField &field, const VesselOptions &options, std::uint64_t seed, std::uint64_t stream);

}  // namespace csd::sim
