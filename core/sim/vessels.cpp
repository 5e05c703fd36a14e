// SPDX-License-Identifier: LGPL-2.1-or-later
#include "sim/vessels.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "sim/ieee_math.h"

namespace csd::sim {
namespace {

struct Vessel {
  double x, y, direction, width, length;  // direction: turns
};

void stamp(NoiseField &field, double x, double y, double radius) {
  const double reach = radius + 1;
  const int n = field.side();
  for (int j = static_cast<int>(floor_of(y - reach)); j <= y + reach; ++j) {
    float *row = field.row(((j % n) + n) % n);
    for (int i = static_cast<int>(floor_of(x - reach)); i <= x + reach; ++i) {
      const double d = std::sqrt((i - x) * (i - x) + (j - y) * (j - y));
      // A round cross-section, at least a sample wide: thinner vessels get fainter instead.
      const double edge = std::max(radius, 1.0), inside = clamp01(1 - d / (edge + 0.5));
      const auto value = static_cast<float>(smoothstep(1.6 * inside) * std::min(1.0, 0.35 + 0.65 * radius));
      float &f = row[((i % n) + n) % n];
      f = std::max(f, value);
    }
  }
}

}  // namespace

void draw_vessels(NoiseField &field, const VesselOptions &options, std::uint64_t seed, std::uint64_t stream) {
  Random random(seed, stream);
  std::vector<Vessel> todo;
  todo.reserve(static_cast<std::size_t>(options.trees));
  for (int i = 0; i < options.trees; ++i) {
    todo.push_back({random.uniform(0, field.side()), random.uniform(0, field.side()), random.uniform(),
                    options.width * random.uniform(0.7, 1.15), options.length * random.uniform(0.7, 1.2)});
  }
  constexpr std::size_t max_vessels = 20000;  // limits the number for any options
  for (std::size_t next = 0; next < todo.size() && next < max_vessels; ++next) {
    Vessel v = todo[next];
    const double chance = options.branches / std::max(v.length, 1.0);  // of a branch, per sample
    double turning = 0, along = 0;
    const double step = std::max(0.7, 0.35 * v.width);
    while (along < v.length) {
      const double taper = 1 - 0.55 * along / v.length;
      stamp(field, v.x, v.y, 0.5 * v.width * taper);
      turning = 0.9 * turning + random.uniform(-1, 1) * options.wind * 0.3;
      v.direction += turning * step * 0.1;
      v.x += step * cos_turns(v.direction);
      v.y += step * sin_turns(v.direction);
      along += step;
      const double width = v.width * taper * random.uniform(0.45, 0.8);
      if (random.uniform() < chance * step && width > options.least) {
        const double side = random.below(2) != 0 ? 1 : -1;
        todo.push_back({v.x, v.y, v.direction + side * random.uniform(0.06, 0.16), width,
                        (v.length - 0.5 * along) * random.uniform(0.45, 0.8)});
      }
    }
  }
}

}  // namespace csd::sim
