// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <bit>
#include <cmath>
#include <cstdint>
#include <initializer_list>

#include "base/random.h"

/// Elementary functions from +, −, ×, ÷ and square root only, which IEEE 754 rounds exactly: they give the same bits on
/// every machine, while libm's differ between versions and instruction sets. core/sim is compiled with
/// -ffp-contract=off.
namespace csd::sim {

inline constexpr double pi = 3.14159265358979323846;

inline double floor_of(double x) {
  return std::floor(x);  // exact, so the same on every machine
}

/// sin(2π·turns), error below 1e−11.
inline double sin_turns(double turns) {
  double r = turns - floor_of(turns + 0.5);  // −½…½
  if (r > 0.25) {
    r = 0.5 - r;
  } else if (r < -0.25) {
    r = -0.5 - r;
  }
  const double x = 2 * pi * r, y = x * x;
  // Taylor, to x¹⁷ at |x| ≤ π/2.
  double s = 1.0 / 355687428096000;
  s = -1.0 / 1307674368000 + y * s;
  s = 1.0 / 6227020800 + y * s;
  s = -1.0 / 39916800 + y * s;
  s = 1.0 / 362880 + y * s;
  s = -1.0 / 5040 + y * s;
  s = 1.0 / 120 + y * s;
  s = -1.0 / 6 + y * s;
  return x + x * y * s;
}

inline double cos_turns(double turns) {
  return sin_turns(turns + 0.25);
}

/// eˣ for x ≤ 700, relative error below 1e−13; 0 below −700; NaN for NaN.
inline double exp_of(double x) {
  if (!(x >= -700)) return x < -700 ? 0 : x;  // a NaN has no exponent to convert
  const double k = floor_of(x * 1.44269504088896340736 + 0.5);
  const double r = (x - k * 0.693147180369123816490) - k * 1.90821492927058770002e-10;  // |r| ≤ ½·ln 2
  // Taylor series up to r¹¹, in independent pairs.
  const double r2 = r * r, r4 = r2 * r2;
  const double p01 = 1 + r, p23 = 0.5 + r * (1.0 / 6), p45 = 1.0 / 24 + r * (1.0 / 120);
  const double p67 = 1.0 / 720 + r * (1.0 / 5040), p89 = 1.0 / 40320 + r * (1.0 / 362880);
  const double pab = 1.0 / 3628800 + r * (1.0 / 39916800);
  const double p = (p01 + r2 * p23) + r4 * ((p45 + r2 * p67) + r4 * (p89 + r2 * pab));
  return p * std::bit_cast<double>(static_cast<std::uint64_t>(static_cast<std::int64_t>(k) + 1023) << 52);
}

/// log₂ of a positive, normal x, error below 1e−10.
inline double log2_of(double x) {
  const auto bits = std::bit_cast<std::uint64_t>(x);
  auto exponent = static_cast<int>(bits >> 52) - 1023;
  double m = std::bit_cast<double>((bits & 0xfffffffffffffu) | 0x3ff0000000000000u);  // 1…2
  if (m > 1.41421356237309505) {
    m *= 0.5;
    ++exponent;
  }
  const double s = (m - 1) / (m + 1), y = s * s;  // |s| ≤ 0.172
  double p = 1.0 / 13;
  for (const double c : {1.0 / 11, 1.0 / 9, 1.0 / 7, 1.0 / 5, 1.0 / 3, 1.0}) p = c + y * p;
  return exponent + 2 * 1.44269504088896340736 * s * p;
}

inline double clamp01(double x) {
  return x < 0 ? 0 : x > 1 ? 1 : x;
}
inline float clamp01(float x) {
  return x < 0 ? 0 : x > 1 ? 1 : x;
}

/// 0 up to x = 0, 1 from x = 1 on, with zero slope at both ends.
inline double smoothstep(double x) {
  x = clamp01(x);
  return x * x * (3 - 2 * x);
}
inline float smoothstep(float x) {
  x = clamp01(x);
  return x * x * (3 - 2 * x);
}

inline double lerp(double a, double b, double f) {
  return a + (b - a) * f;
}

/// Rises over `rise` from `start` on, stays 1, falls over `fall` to 0 at `end`.
inline double window(double t, double start, double rise, double end, double fall) {
  return smoothstep((t - start) / rise) * smoothstep((end - t) / fall);
}

/// A number in [0,1) from a hash of three numbers: random access to random numbers.
inline double hashed(std::uint64_t seed, std::uint64_t stream, std::int64_t index) {
  return Random(seed + 0x632be59bd9b4e019u * stream, static_cast<std::uint64_t>(index)).uniform();
}

/// Smooth noise over time, −1…1, about one independent value per unit of t.
inline double wander(std::uint64_t seed, std::uint64_t stream, double t) {
  const double k = floor_of(t);
  const auto i = static_cast<std::int64_t>(k);
  const double a = hashed(seed, stream, i), b = hashed(seed, stream, i + 1);
  return 2 * lerp(a, b, smoothstep(t - k)) - 1;
}

}  // namespace csd::sim
