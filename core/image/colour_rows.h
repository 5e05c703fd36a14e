// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <cstdint>

#include "image/colour_space.h"

namespace csd {

/// Y'CbCr to full-range R'G'B' (ITU-R BT.601, BT.709, BT.2020: one form, two parameters) in 13-bit fixed point.
///
/// Each product is floor(a·c / 2^16) with a in 1/128 and c in 1/8192, thus in 1/16 of a step, and fits 16 bit; the sum
/// is rounded to nearest. It differs from the rounded exact value by at most 1; without colour, R = G = B exactly.
struct YuvCoefficients {
  std::int16_t y = 0, r_v = 0, g_u = 0, g_v = 0, b_u = 0;  ///< 1/8192; g_u and g_v are subtracted
  std::int16_t black = 0;                                  ///< Y of black: 16, or 0 in full range

  /// Values of kr and kb that make no matrix (not in 0…1, or 1 together) are taken as BT.709's.
  static YuvCoefficients make(double kr, double kb, bool full_range);
};

/// R, G, B to Y' in full range: each product is floor(a·c / 2^8) with c in 1/65536; the sum is rounded. The weights add
/// up to 65536 (65535 where one of them would be that), so gray keeps its value; else it is within 0.52 of the exact
/// one.
struct LumaCoefficients {
  std::uint16_t r = 0, g = 0, b = 0;
  static LumaCoefficients make(double kr, double kb);
};

/// Kernels on rows of n ≥ 0 pixels, dispatched to the best SIMD target of the machine at run time. Outputs must not
/// overlap inputs.
void yuv_to_rgb(const YuvCoefficients &c, const std::uint8_t *y, const std::uint8_t *u, const std::uint8_t *v, int n,
                std::uint8_t *r, std::uint8_t *g, std::uint8_t *b);
void rgb_to_space(const ColourSpace &space, const std::uint8_t *r, const std::uint8_t *g, const std::uint8_t *b, int n,
                  std::uint8_t *out);
void rgb_to_luma(const LumaCoefficients &c, const std::uint8_t *r, const std::uint8_t *g, const std::uint8_t *b, int n,
                 std::uint8_t *out);
/// Least of R, G and B, as yuv_to_rgb() gives them: first what U and V add to the least, in 1/16 of a step, each value
/// `copies` (1 or 2) times in a row; then with Y.
void chroma_least(const YuvCoefficients &c, const std::uint8_t *u, const std::uint8_t *v, int n, int copies,
                  std::int16_t *out);
void yuv_least(const YuvCoefficients &c, const std::uint8_t *y, const std::int16_t *chroma, int n, std::uint8_t *out);
void rgb_least(const std::uint8_t *r, const std::uint8_t *g, const std::uint8_t *b, int n, std::uint8_t *out);
/// Three rows to one of 3n bytes: a0 b0 c0 a1 b1 c1 …
void interleave(const std::uint8_t *a, const std::uint8_t *b, const std::uint8_t *c, int n, std::uint8_t *out);

/// The same without SIMD; what tests compare with, bit for bit.
namespace scalar {
void chroma_least(const YuvCoefficients &c, const std::uint8_t *u, const std::uint8_t *v, int n, int copies,
                  std::int16_t *out);
void yuv_least(const YuvCoefficients &c, const std::uint8_t *y, const std::int16_t *chroma, int n, std::uint8_t *out);
void rgb_least(const std::uint8_t *r, const std::uint8_t *g, const std::uint8_t *b, int n, std::uint8_t *out);
void rgb_to_luma(const LumaCoefficients &c, const std::uint8_t *r, const std::uint8_t *g, const std::uint8_t *b, int n,
                 std::uint8_t *out);
void yuv_to_rgb(const YuvCoefficients &c, const std::uint8_t *y, const std::uint8_t *u, const std::uint8_t *v, int n,
                std::uint8_t *r, std::uint8_t *g, std::uint8_t *b);
void rgb_to_space(const ColourSpace &space, const std::uint8_t *r, const std::uint8_t *g, const std::uint8_t *b, int n,
                  std::uint8_t *out);
void interleave(const std::uint8_t *a, const std::uint8_t *b, const std::uint8_t *c, int n, std::uint8_t *out);
}  // namespace scalar

}  // namespace csd
