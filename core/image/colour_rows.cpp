// SPDX-License-Identifier: LGPL-2.1-or-later
#include "image/colour_rows.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "image/colour_rows.cpp"
#include <hwy/foreach_target.h>
// After foreach_target.
#include <hwy/highway.h>

#include <algorithm>
#include <cmath>

HWY_BEFORE_NAMESPACE();
namespace csd::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

// 16-bit lanes: as many pixels at once as fit a vector.
const hn::ScalableTag<std::int16_t> i16;
const hn::ScalableTag<std::uint16_t> u16;
const hn::Rebind<std::uint8_t, decltype(i16)> u8;

/// Calls kernel(i) for i = 0, N, 2N … and once more for the last N, so that no pixel is left to scalar code (some are
/// computed twice). The caller handles rows shorter than N.
template <class Kernel>
HWY_INLINE void cover(int n, int step, Kernel kernel) {
  int i = 0;
  for (; i + step <= n; i += step) kernel(i);
  if (i < n) kernel(n - step);
}

void YuvToRgb(const YuvCoefficients &c, const std::uint8_t *y, const std::uint8_t *u, const std::uint8_t *v, int n,
              std::uint8_t *r, std::uint8_t *g, std::uint8_t *b) {
  const int lanes = static_cast<int>(hn::Lanes(i16));
  if (n < lanes) return scalar::yuv_to_rgb(c, y, u, v, n, r, g, b);
  const auto black = hn::Set(i16, c.black), grey = hn::Set(i16, 128), half = hn::Set(i16, 8);
  const auto cy = hn::Set(i16, c.y), rv = hn::Set(i16, c.r_v), gu = hn::Set(i16, c.g_u), gv = hn::Set(i16, c.g_v),
             bu = hn::Set(i16, c.b_u);
  cover(n, lanes, [&](int i) HWY_ATTR {
    const auto yy = hn::ShiftLeft<7>(hn::Sub(hn::PromoteTo(i16, hn::LoadU(u8, y + i)), black));
    const auto uu = hn::ShiftLeft<7>(hn::Sub(hn::PromoteTo(i16, hn::LoadU(u8, u + i)), grey));
    const auto vv = hn::ShiftLeft<7>(hn::Sub(hn::PromoteTo(i16, hn::LoadU(u8, v + i)), grey));
    const auto luma = hn::Add(hn::MulHigh(yy, cy), half);
    const auto red = hn::Add(luma, hn::MulHigh(vv, rv));
    const auto green = hn::Sub(luma, hn::Add(hn::MulHigh(uu, gu), hn::MulHigh(vv, gv)));
    const auto blue = hn::Add(luma, hn::MulHigh(uu, bu));
    hn::StoreU(hn::DemoteTo(u8, hn::ShiftRight<4>(red)), u8, r + i);
    hn::StoreU(hn::DemoteTo(u8, hn::ShiftRight<4>(green)), u8, g + i);
    hn::StoreU(hn::DemoteTo(u8, hn::ShiftRight<4>(blue)), u8, b + i);
  });
}

// Eq. 7, ColourSpace::apply(), for a row of pixels.
void RgbToSpace(const ColourSpace &space, const std::uint8_t *r, const std::uint8_t *g, const std::uint8_t *b, int n,
                std::uint8_t *out) {
  const int lanes = static_cast<int>(hn::Lanes(i16));
  const int span = space.span();
  if (n < lanes || span == 0) return scalar::rgb_to_space(space, r, g, b, n, out);
  const auto wr = hn::Set(i16, space.r), wg = hn::Set(i16, space.g), wb = hn::Set(i16, space.b);
  const auto offset = hn::Set(i16, static_cast<std::int16_t>(space.below()));
  // x / span for x ≤ 1530 is 2x · ceil(2^15/span) >> 16: the error, below 2x/2^16, is less than 1/span.
  const auto reciprocal = hn::Set(u16, static_cast<std::uint16_t>((32768 + span - 1) / span));
  cover(n, lanes, [&](int i) HWY_ATTR {
    const auto rr = hn::Mul(hn::PromoteTo(i16, hn::LoadU(u8, r + i)), wr);
    const auto gg = hn::Mul(hn::PromoteTo(i16, hn::LoadU(u8, g + i)), wg);
    const auto bb = hn::Mul(hn::PromoteTo(i16, hn::LoadU(u8, b + i)), wb);
    const auto sum = hn::BitCast(u16, hn::Add(hn::Add(rr, gg), hn::Add(bb, offset)));
    const auto quotient = hn::MulHigh(hn::Add(sum, sum), reciprocal);
    hn::StoreU(hn::DemoteTo(u8, hn::BitCast(i16, quotient)), u8, out + i);
  });
}

void RgbToLuma(const LumaCoefficients &c, const std::uint8_t *r, const std::uint8_t *g, const std::uint8_t *b, int n,
               std::uint8_t *out) {
  const int lanes = static_cast<int>(hn::Lanes(u16));
  if (n < lanes) return scalar::rgb_to_luma(c, r, g, b, n, out);
  const auto cr = hn::Set(u16, c.r), cg = hn::Set(u16, c.g), cb = hn::Set(u16, c.b), half = hn::Set(u16, 128);
  cover(n, lanes, [&](int i) HWY_ATTR {
    const auto rr = hn::MulHigh(hn::ShiftLeft<8>(hn::PromoteTo(u16, hn::LoadU(u8, r + i))), cr);
    const auto gg = hn::MulHigh(hn::ShiftLeft<8>(hn::PromoteTo(u16, hn::LoadU(u8, g + i))), cg);
    const auto bb = hn::MulHigh(hn::ShiftLeft<8>(hn::PromoteTo(u16, hn::LoadU(u8, b + i))), cb);
    const auto sum = hn::ShiftRight<8>(hn::Add(hn::Add(rr, gg), hn::Add(bb, half)));
    hn::StoreU(hn::DemoteTo(u8, hn::BitCast(i16, sum)), u8, out + i);
  });
}

void ChromaLeast(const YuvCoefficients &c, const std::uint8_t *u, const std::uint8_t *v, int n, int copies,
                 std::int16_t *out) {
  const int lanes = static_cast<int>(hn::Lanes(i16));
  if (n < lanes) return scalar::chroma_least(c, u, v, n, copies, out);
  const auto grey = hn::Set(i16, 128);
  const auto rv = hn::Set(i16, c.r_v), gu = hn::Set(i16, c.g_u), gv = hn::Set(i16, c.g_v), bu = hn::Set(i16, c.b_u);
  cover(n, lanes, [&](int i) HWY_ATTR {
    const auto uu = hn::ShiftLeft<7>(hn::Sub(hn::PromoteTo(i16, hn::LoadU(u8, u + i)), grey));
    const auto vv = hn::ShiftLeft<7>(hn::Sub(hn::PromoteTo(i16, hn::LoadU(u8, v + i)), grey));
    const auto green = hn::Neg(hn::Add(hn::MulHigh(uu, gu), hn::MulHigh(vv, gv)));
    const auto least_chroma = hn::Min(hn::Min(hn::MulHigh(vv, rv), hn::MulHigh(uu, bu)), green);
    if (copies == 4)
      hn::StoreInterleaved4(least_chroma, least_chroma, least_chroma, least_chroma, i16, out + 4 * i);
    else if (copies == 2)
      hn::StoreInterleaved2(least_chroma, least_chroma, i16, out + 2 * i);
    else
      hn::StoreU(least_chroma, i16, out + i);
  });
}

void YuvLeast(const YuvCoefficients &c, const std::uint8_t *y, const std::int16_t *chroma, int n, std::uint8_t *out) {
  const int lanes = static_cast<int>(hn::Lanes(i16));
  if (n < lanes) return scalar::yuv_least(c, y, chroma, n, out);
  const auto black = hn::Set(i16, c.black), half = hn::Set(i16, 8), cy = hn::Set(i16, c.y);
  cover(n, lanes, [&](int i) HWY_ATTR {
    const auto yy = hn::ShiftLeft<7>(hn::Sub(hn::PromoteTo(i16, hn::LoadU(u8, y + i)), black));
    const auto least_channel = hn::Add(hn::Add(hn::MulHigh(yy, cy), half), hn::LoadU(i16, chroma + i));
    hn::StoreU(hn::DemoteTo(u8, hn::ShiftRight<4>(least_channel)), u8, out + i);
  });
}

void RgbLeast(const std::uint8_t *r, const std::uint8_t *g, const std::uint8_t *b, int n, std::uint8_t *out) {
  const hn::ScalableTag<std::uint8_t> d;
  const int lanes = static_cast<int>(hn::Lanes(d));
  if (n < lanes) return scalar::rgb_least(r, g, b, n, out);
  cover(n, lanes, [&](int i) HWY_ATTR {
    hn::StoreU(hn::Min(hn::Min(hn::LoadU(d, r + i), hn::LoadU(d, g + i)), hn::LoadU(d, b + i)), d, out + i);
  });
}

void Interleave(const std::uint8_t *a, const std::uint8_t *b, const std::uint8_t *c, int n, std::uint8_t *out) {
  const hn::ScalableTag<std::uint8_t> d;
  const int lanes = static_cast<int>(hn::Lanes(d));
  if (n < lanes) return scalar::interleave(a, b, c, n, out);
  cover(n, lanes, [&](int i) HWY_ATTR {
    hn::StoreInterleaved3(hn::LoadU(d, a + i), hn::LoadU(d, b + i), hn::LoadU(d, c + i), d, out + 3 * i);
  });
}

}  // namespace csd::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace csd {

HWY_EXPORT(YuvToRgb);
HWY_EXPORT(RgbToSpace);
HWY_EXPORT(RgbToLuma);
HWY_EXPORT(ChromaLeast);
HWY_EXPORT(YuvLeast);
HWY_EXPORT(RgbLeast);
HWY_EXPORT(Interleave);

YuvCoefficients YuvCoefficients::make(double kr, double kb, bool full_range) {
  if (!(kr >= 0 && kb >= 0 && kr + kb < 1)) {
    kr = 0.2126;
    kb = 0.0722;
  }
  const double kg = 1 - kr - kb;
  const double y = full_range ? 1 : 255.0 / 219, chroma = full_range ? 1 : 255.0 / 224;
  const auto fixed = [](double c) { return static_cast<std::int16_t>(std::lround(std::min(c * 8192, 32767.0))); };
  return {.y = fixed(y),
          .r_v = fixed(2 * (1 - kr) * chroma),
          .g_u = fixed(2 * (1 - kb) * kb / kg * chroma),
          .g_v = fixed(2 * (1 - kr) * kr / kg * chroma),
          .b_u = fixed(2 * (1 - kb) * chroma),
          .black = static_cast<std::int16_t>(full_range ? 0 : 16)};
}

LumaCoefficients LumaCoefficients::make(double kr, double kb) {
  if (!(kr >= 0 && kb >= 0 && kr + kb < 1)) {
    kr = 0.2126;
    kb = 0.0722;
  }
  const auto r = static_cast<int>(std::lround(kr * 65536)), b = static_cast<int>(std::lround(kb * 65536));
  const auto fixed = [](int c) { return static_cast<std::uint16_t>(std::clamp(c, 0, 65535)); };
  return {.r = fixed(r), .g = fixed(65536 - r - b), .b = fixed(b)};
}

void yuv_to_rgb(const YuvCoefficients &c, const std::uint8_t *y, const std::uint8_t *u, const std::uint8_t *v, int n,
                std::uint8_t *r, std::uint8_t *g, std::uint8_t *b) {
  HWY_DYNAMIC_DISPATCH(YuvToRgb)(c, y, u, v, n, r, g, b);
}

void rgb_to_space(const ColourSpace &space, const std::uint8_t *r, const std::uint8_t *g, const std::uint8_t *b, int n,
                  std::uint8_t *out) {
  HWY_DYNAMIC_DISPATCH(RgbToSpace)(space, r, g, b, n, out);
}

void rgb_to_luma(const LumaCoefficients &c, const std::uint8_t *r, const std::uint8_t *g, const std::uint8_t *b, int n,
                 std::uint8_t *out) {
  HWY_DYNAMIC_DISPATCH(RgbToLuma)(c, r, g, b, n, out);
}

void chroma_least(const YuvCoefficients &c, const std::uint8_t *u, const std::uint8_t *v, int n, int copies,
                  std::int16_t *out) {
  HWY_DYNAMIC_DISPATCH(ChromaLeast)(c, u, v, n, copies, out);
}

void yuv_least(const YuvCoefficients &c, const std::uint8_t *y, const std::int16_t *chroma, int n, std::uint8_t *out) {
  HWY_DYNAMIC_DISPATCH(YuvLeast)(c, y, chroma, n, out);
}

void rgb_least(const std::uint8_t *r, const std::uint8_t *g, const std::uint8_t *b, int n, std::uint8_t *out) {
  HWY_DYNAMIC_DISPATCH(RgbLeast)(r, g, b, n, out);
}

void interleave(const std::uint8_t *a, const std::uint8_t *b, const std::uint8_t *c, int n, std::uint8_t *out) {
  HWY_DYNAMIC_DISPATCH(Interleave)(a, b, c, n, out);
}

namespace scalar {
namespace {

int times(int a, int coefficient) {
  return (a * 128 * coefficient) >> 16;
}

std::uint8_t to_byte(int x) {
  return static_cast<std::uint8_t>(std::clamp(x >> 4, 0, 255));
}

}  // namespace

void yuv_to_rgb(const YuvCoefficients &c, const std::uint8_t *y, const std::uint8_t *u, const std::uint8_t *v, int n,
                std::uint8_t *r, std::uint8_t *g, std::uint8_t *b) {
  for (int i = 0; i < n; ++i) {
    const int luma = times(y[i] - c.black, c.y) + 8, cb = u[i] - 128, cr = v[i] - 128;
    r[i] = to_byte(luma + times(cr, c.r_v));
    g[i] = to_byte(luma - (times(cb, c.g_u) + times(cr, c.g_v)));
    b[i] = to_byte(luma + times(cb, c.b_u));
  }
}

void chroma_least(const YuvCoefficients &c, const std::uint8_t *u, const std::uint8_t *v, int n, int copies,
                  std::int16_t *out) {
  for (int i = 0; i < n; ++i) {
    const int cb = u[i] - 128, cr = v[i] - 128;
    const int least_chroma = std::min({times(cr, c.r_v), -(times(cb, c.g_u) + times(cr, c.g_v)), times(cb, c.b_u)});
    out = std::fill_n(out, copies, static_cast<std::int16_t>(least_chroma));
  }
}

void yuv_least(const YuvCoefficients &c, const std::uint8_t *y, const std::int16_t *chroma, int n, std::uint8_t *out) {
  for (int i = 0; i < n; ++i) out[i] = to_byte(times(y[i] - c.black, c.y) + 8 + chroma[i]);
}

void rgb_least(const std::uint8_t *r, const std::uint8_t *g, const std::uint8_t *b, int n, std::uint8_t *out) {
  for (int i = 0; i < n; ++i) out[i] = std::min({r[i], g[i], b[i]});
}

void rgb_to_space(const ColourSpace &space, const std::uint8_t *r, const std::uint8_t *g, const std::uint8_t *b, int n,
                  std::uint8_t *out) {
  for (int i = 0; i < n; ++i) out[i] = space.apply(r[i], g[i], b[i]);
}

void rgb_to_luma(const LumaCoefficients &c, const std::uint8_t *r, const std::uint8_t *g, const std::uint8_t *b, int n,
                 std::uint8_t *out) {
  for (int i = 0; i < n; ++i)
    out[i] = static_cast<std::uint8_t>(((r[i] * c.r >> 8) + (g[i] * c.g >> 8) + (b[i] * c.b >> 8) + 128) >> 8);
}

void interleave(const std::uint8_t *a, const std::uint8_t *b, const std::uint8_t *c, int n, std::uint8_t *out) {
  for (int i = 0; i < n; ++i, out += 3) {
    out[0] = a[i];
    out[1] = b[i];
    out[2] = c[i];
  }
}

}  // namespace scalar
}  // namespace csd
#endif
