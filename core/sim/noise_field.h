// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <cstdint>
#include <vector>

namespace csd::sim {

/// A square field of floats, periodic in both directions.
class NoiseField {
 public:
  explicit NoiseField(int side = 1, float value = 0)
      : side_(side), data_(static_cast<std::size_t>(side) * static_cast<std::size_t>(side), value) {}

  int side() const { return side_; }
  /// x, y ≥ −side.
  float at(int x, int y) const { return row((y + side_) % side_)[(x + side_) % side_]; }
  float *row(int y) { return data_.data() + static_cast<std::size_t>(y) * static_cast<std::size_t>(side_); }
  const float *row(int y) const { return data_.data() + static_cast<std::size_t>(y) * static_cast<std::size_t>(side_); }
  std::vector<float> &values() { return data_; }
  const std::vector<float> &values() const { return data_; }

  /// Doubles the resolution with cubic B-splines.
  NoiseField doubled() const;

  /// Shifts and scales to mean 0 and deviation 1 (a constant field to 0).
  void normalise();

 private:
  int side_;
  std::vector<float> data_;
};

struct Octave {
  double size;    ///< of a blob, samples
  double weight;  ///< its share of the deviation
};

/// Smooth noise with blobs of several sizes, mean 0 and deviation 1. `side` is a power of two. Sizes are approximate
/// within a factor √2.
NoiseField fractal_noise(int side, const std::vector<Octave> &octaves, std::uint64_t seed, std::uint64_t stream);

struct Cells {
  NoiseField edge;   ///< 0 at the border between two cells, about 1 in the middle of a cell
  NoiseField value;  ///< a random number in 0…1 for each cell
};

/// Voronoi cells of random points (Worley 1996), about `size` samples apart; `jitter` 0 (a lattice) … 1.
Cells cells(int side, double size, double jitter, std::uint64_t seed, std::uint64_t stream);

}  // namespace csd::sim
