// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <cstdint>

namespace csd {

/// Mirrors an index into 0…n−1, n ≥ 1, without repeating the border: … 2 1 0 1 2 … n−2 n−1 n−2 …,
/// cv::BORDER_REFLECT_101.
constexpr int mirrored(int i, int n) {
  if (n == 1) return 0;
  while (i < 0 || i >= n) i = i < 0 ? -i : 2 * (n - 1) - i;
  return i;
}

/// Row kernels of Pyramid and GlareWeights for n ≥ 1 pixels, dispatched to the machine's best SIMD target at run time.
/// The caller chooses the rows above and below; columns outside a row are mirrored() unless stated otherwise. Outputs
/// must not overlap inputs. `scratch` holds n + row_slack elements.
constexpr int row_slack = 8;

/// 1 4 6 4 1 down five rows and along: the sum, which is the smoothed row in 1/256.
void smooth_row(const std::uint8_t *const rows[5], int n, std::uint16_t *scratch, std::uint16_t *out);
/// The same filter at every second column, rounded to nearest: (n+1)/2 outputs.
void shrink_row(const std::uint16_t *const rows[5], int n, std::uint32_t *scratch, std::uint16_t *out);
/// 1 2 1 down three rows and along at every second column, rounded to nearest: (n+1)/2 outputs.
void mean_row(const std::uint8_t *const rows[3], int n, std::uint16_t *scratch, std::uint8_t *out);
/// Where `forbidden` is 0 (it is 255 elsewhere): sums[i] += row[i] and counts[i] += 1, modulo 2^16.
void add_row(const std::uint8_t *row, const std::uint8_t *forbidden, int n, std::uint16_t *sums, std::uint16_t *counts);
/// Compares 1 2 1 down three rows and along with a limit in 1/256 between `above` and `below`, floor(above·(65535 −
/// part) / 65536) + floor(below·part / 65536): 0 if it is above the limit, else 255.
void tissue_row(const std::uint8_t *const rows[3], const std::uint16_t *above, const std::uint16_t *below,
                std::uint16_t part, int n, std::uint16_t *scratch, std::uint8_t *out);
/// Minimum over five rows and five columns, those outside excluded, of pixels that are 0 or 255; `marked` instead of 0;
/// 0 where `forbidden` is 255 (it is 0 elsewhere).
inline constexpr std::uint8_t marked = 128;
void erode_row(const std::uint8_t *const rows[5], const std::uint8_t *forbidden, int n, std::uint8_t *scratch,
               std::uint8_t *out);

/// The same without SIMD, the bit-exact reference for tests.
namespace scalar {
void smooth_row(const std::uint8_t *const rows[5], int n, std::uint16_t *scratch, std::uint16_t *out);
void shrink_row(const std::uint16_t *const rows[5], int n, std::uint32_t *scratch, std::uint16_t *out);
void mean_row(const std::uint8_t *const rows[3], int n, std::uint16_t *scratch, std::uint8_t *out);
void add_row(const std::uint8_t *row, const std::uint8_t *forbidden, int n, std::uint16_t *sums, std::uint16_t *counts);
void tissue_row(const std::uint8_t *const rows[3], const std::uint16_t *above, const std::uint16_t *below,
                std::uint16_t part, int n, std::uint16_t *scratch, std::uint8_t *out);
void erode_row(const std::uint8_t *const rows[5], const std::uint8_t *forbidden, int n, std::uint8_t *scratch,
               std::uint8_t *out);
}  // namespace scalar

}  // namespace csd
