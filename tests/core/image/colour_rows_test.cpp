// SPDX-License-Identifier: LGPL-2.1-or-later
#include "image/colour_rows.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include "core/simd_targets.h"

namespace csd {
namespace {

using Bytes = std::vector<std::uint8_t>;

Bytes noise(std::size_t n, unsigned seed) {
  std::mt19937 random(seed);
  Bytes out(n);
  for (auto &b : out) b = static_cast<std::uint8_t>(random());
  return out;
}

struct Matrix {
  double kr, kb;
};
constexpr Matrix matrices[] = {{0.299, 0.114}, {0.2126, 0.0722}, {0.2627, 0.0593}};  // BT.601, BT.709, BT.2020

void kernels_are_their_scalar_twins() {
  const Bytes a = noise(220, 1), b = noise(220, 2), c = noise(220, 3);
  for (int n = 0; n < 200; ++n)
    for (const int at : {0, 1, 5}) {
      const auto size = static_cast<std::size_t>(n);
      const std::uint8_t *p = a.data() + at, *q = b.data() + at + 1, *r = c.data() + 3;
      Bytes fast(3 * size + 1, 9), slow(fast);
      const auto m = YuvCoefficients::make(0.2126, 0.0722, n % 2);
      yuv_to_rgb(m, p, q, r, n, fast.data(), fast.data() + size, fast.data() + 2 * size);
      scalar::yuv_to_rgb(m, p, q, r, n, slow.data(), slow.data() + size, slow.data() + 2 * size);
      ASSERT_EQ(fast, slow) << n;
      interleave(p, q, r, n, fast.data());
      scalar::interleave(p, q, r, n, slow.data());
      ASSERT_EQ(fast, slow) << n;
      rgb_least(p, q, r, n, fast.data());
      scalar::rgb_least(p, q, r, n, slow.data());
      ASSERT_EQ(fast, slow) << n;
      std::vector<std::int16_t> chroma(4 * size + 1, 9), slow_chroma(chroma);
      for (const int copies : {1, 2, 4}) {
        chroma_least(m, q, r, n, copies, chroma.data());
        scalar::chroma_least(m, q, r, n, copies, slow_chroma.data());
        ASSERT_EQ(chroma, slow_chroma) << n;
      }
      yuv_least(m, p, chroma.data(), n, fast.data());
      scalar::yuv_least(m, p, chroma.data(), n, slow.data());
      ASSERT_EQ(fast, slow) << n;
      const auto luma = LumaCoefficients::make(0.299, 0.114);
      rgb_to_luma(luma, p, q, r, n, fast.data());
      scalar::rgb_to_luma(luma, p, q, r, n, slow.data());
      ASSERT_EQ(fast, slow) << n;
      for (const auto &space : colour_spaces()) {
        rgb_to_space(space, p, q, r, n, fast.data());
        scalar::rgb_to_space(space, p, q, r, n, slow.data());
        ASSERT_EQ(fast, slow) << n;
      }
    }
}

TEST(ColourRows, KernelsMatchTheirScalarTwins) {
  test::on_all_targets(kernels_are_their_scalar_twins);
}

/// Every Y, U and V, against the formula of BT.601 §2.5 and its successors in double.
TEST(ColourRows, RgbIsWithinOneOfTheExactValue) {
  Bytes y(256), u(256), v(256), out[3] = {Bytes(256), Bytes(256), Bytes(256)};
  for (std::size_t i = 0; i < 256; ++i) y[i] = static_cast<std::uint8_t>(i);
  for (const Matrix &m : matrices)
    for (const bool full : {false, true}) {
      const auto c = YuvCoefficients::make(m.kr, m.kb, full);
      const double luma = full ? 1 : 255.0 / 219, chroma = full ? 1 : 255.0 / 224, kg = 1 - m.kr - m.kb;
      double worst = 0;
      for (int cb = 0; cb < 256; ++cb)
        for (int cr = 0; cr < 256; ++cr) {
          std::fill(u.begin(), u.end(), static_cast<std::uint8_t>(cb));
          std::fill(v.begin(), v.end(), static_cast<std::uint8_t>(cr));
          yuv_to_rgb(c, y.data(), u.data(), v.data(), 256, out[0].data(), out[1].data(), out[2].data());
          const double b = 2 * (1 - m.kb) * (cb - 128) * chroma, r = 2 * (1 - m.kr) * (cr - 128) * chroma;
          for (int i = 0; i < 256; ++i) {
            const double l = (i - (full ? 0 : 16)) * luma;
            const double exact[3] = {l + r, l - (m.kr * r + m.kb * b) / kg, l + b};
            for (int k = 0; k < 3; ++k) {
              const double rounded = std::round(std::clamp(exact[k], 0.0, 255.0));
              worst = std::max(worst, std::abs(out[k][static_cast<std::size_t>(i)] - rounded));
            }
          }
        }
      EXPECT_LE(worst, 1) << m.kr << full;
    }
}

TEST(ColourRows, LumaIsTheWeightedSumAndGrayIsKept) {
  for (const Matrix &m : matrices) {
    const auto c = LumaCoefficients::make(m.kr, m.kb);
    for (int r = 0; r < 256; r += 3)
      for (int g = 0; g < 256; g += 5)
        for (int b = 0; b < 256; b += 5) {
          const std::uint8_t in[3] = {static_cast<std::uint8_t>(r), static_cast<std::uint8_t>(g),
                                      static_cast<std::uint8_t>(b)};
          std::uint8_t out;
          rgb_to_luma(c, in, in + 1, in + 2, 1, &out);
          ASSERT_NEAR(out, m.kr * r + (1 - m.kr - m.kb) * g + m.kb * b, 0.52);
          if (r == g && g == b) {
            ASSERT_EQ(out, r);
          }
        }
  }
}

}  // namespace
}  // namespace csd
