// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <cstdint>

#include "image/colour_space.h"

namespace csd {

/// Y'CbCr to full-range R'G'B' (ITU-R BT.601, BT.709, BT.2020: the same form with two parameters) in 13-bit fixed
/// point.
///
/// Each product is floor(a·c / 2^16) with a in 1/128 and c in 1/8192, so it is in 1/16 of a step and fits 16 bit. The
/// sum is rounded to nearest and differs from the rounded exact value by at most 1. Without colour, R = G = B exactly.
struct YuvCoefficients {
  std::int16_t y = 0, r_v = 0, g_u = 0, g_v = 0, b_u = 0;  ///< 1/8192; g_u and g_v are subtracted
  std::int16_t black = 0;                                  ///< Y of black: 16, or 0 in full range

  /// Invalid kr and kb (not in 0…1, or 1 together) are replaced by BT.709's.
  static YuvCoefficients make(double kr, double kb, bool full_range);
};

/// R, G, B to full-range Y': each product is floor(a·c / 2^8) with c in 1/65536; the sum is rounded. The weights sum to
/// 65536 (65535 if one of them would be that), so gray keeps its value; other colours are within 0.52 of the exact
/// value.
struct LumaCoefficients {
  std::uint16_t r = 0, g = 0, b = 0;
  static LumaCoefficients make(double kr, double kb);
};

/// Kernels for rows of n ≥ 0 pixels, dispatched to the machine's best SIMD target at run time. Outputs must not overlap
/// inputs.
void yuv_to_rgb(const YuvCoefficients &c, const std::uint8_t *y, const std::uint8_t *u, const std::uint8_t *v, int n,
                std::uint8_t *r, std::uint8_t *g, std::uint8_t *b);
void rgb_to_space(const ColourSpace &space, const std::uint8_t *r, const std::uint8_t *g, const std::uint8_t *b, int n,
                  std::uint8_t *out);
void rgb_to_luma(const LumaCoefficients &c, const std::uint8_t *r, const std::uint8_t *g, const std::uint8_t *b, int n,
                 std::uint8_t *out);
/// The smallest of R, G and B as yuv_to_rgb() gives them, in two steps: chroma_least() computes the smallest
/// contribution of U and V, in 1/16 of a step, each value repeated `copies` (1, 2 or 4) times; yuv_least() adds Y.
void chroma_least(const YuvCoefficients &c, const std::uint8_t *u, const std::uint8_t *v, int n, int copies,
                  std::int16_t *out);
void yuv_least(const YuvCoefficients &c, const std::uint8_t *y, const std::int16_t *chroma, int n, std::uint8_t *out);
void rgb_least(const std::uint8_t *r, const std::uint8_t *g, const std::uint8_t *b, int n, std::uint8_t *out);
/// Interleaves three rows to one of 3n bytes: a0 b0 c0 a1 b1 c1 …
void interleave(const std::uint8_t *a, const std::uint8_t *b, const std::uint8_t *c, int n, std::uint8_t *out);

/// The same without SIMD, the bit-exact reference for tests.
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
