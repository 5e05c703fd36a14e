// SPDX-License-Identifier: LGPL-2.1-or-later
#include "image/frame_rows.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "image/frame_rows.cpp"
#include <hwy/foreach_target.h>
// After foreach_target.
#include <hwy/highway.h>

#include <algorithm>
#include <cstddef>

HWY_BEFORE_NAMESPACE();
namespace csd::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

const hn::ScalableTag<std::uint8_t> u8;
const hn::ScalableTag<std::uint16_t> u16;
const hn::ScalableTag<std::uint32_t> u32;
const hn::RebindToSigned<decltype(u16)> i16;
const hn::RebindToSigned<decltype(u32)> i32;
const hn::Rebind<std::uint8_t, decltype(u16)> half_u8;
const hn::Rebind<std::uint16_t, decltype(u32)> half_u16;

template <class D>
HWY_INLINE int lanes(D d) {
  return static_cast<int>(hn::Lanes(d));
}

/// Calls kernel(i) at multiples of D's lanes, and once more for the last vector of the n pixels.
template <class D, class Kernel>
HWY_INLINE void cover(int n, D d, Kernel kernel) {
  const int step = lanes(d);
  int i = 0;
  for (; i + step <= n; i += step) kernel(i);
  if (i < n) kernel(n - step);
}

/// 1 4 6 4 1.
template <class V>
HWY_INLINE V Binomial(V a, V b, V c, V d, V e) {
  return hn::Add(hn::Add(hn::Add(a, e), hn::Add(c, c)), hn::ShiftLeft<2>(hn::Add(hn::Add(b, d), c)));
}

/// 1 2 1.
template <class V>
HWY_INLINE V Tent(V a, V b, V c) {
  return hn::Add(hn::Add(a, c), hn::Add(b, b));
}

void SmoothRow(const std::uint8_t *const rows[5], int n, std::uint16_t *scratch, std::uint16_t *out) {
  if (n < lanes(u16)) return scalar::smooth_row(rows, n, scratch, out);
  std::uint16_t *const sums = scratch + 2;
  cover(n, u16, [&](int i) HWY_ATTR {
    const auto at = [&](int k) HWY_ATTR { return hn::PromoteTo(u16, hn::LoadU(half_u8, rows[k] + i)); };
    hn::StoreU(Binomial(at(0), at(1), at(2), at(3), at(4)), u16, sums + i);
  });
  for (const int i : {-2, -1, n, n + 1}) sums[i] = sums[mirrored(i, n)];
  cover(n, u16, [&](int i) HWY_ATTR {
    const auto at = [&](int k) HWY_ATTR { return hn::LoadU(u16, sums + i + k); };
    hn::StoreU(Binomial(at(-2), at(-1), at(0), at(1), at(2)), u16, out + i);
  });
}

#if HWY_TARGET == HWY_SCALAR  // no vectors to split into pairs

void ShrinkRow(const std::uint16_t *const rows[5], int n, std::uint32_t *scratch, std::uint16_t *out) {
  scalar::shrink_row(rows, n, scratch, out);
}

void MeanRow(const std::uint8_t *const rows[3], int n, std::uint16_t *scratch, std::uint8_t *out) {
  scalar::mean_row(rows, n, scratch, out);
}

#else

/// Even and odd columns in 32 bit: the low and high halves of pairs, which needs no shuffle.
void ShrinkRow(const std::uint16_t *const rows[5], int n, std::uint32_t *scratch, std::uint16_t *out) {
  const int pairs = n / 2, outputs = (n + 1) / 2;
  if (pairs < lanes(u32)) return scalar::shrink_row(rows, n, scratch, out);
  std::uint32_t *const even = scratch + 1, *const odd = even + outputs + 2;
  const auto low = hn::Set(u32, 0xffff);
  cover(pairs, u32, [&](int i) HWY_ATTR {
    const auto at = [&](int k) HWY_ATTR { return hn::BitCast(u32, hn::LoadU(u16, rows[k] + 2 * i)); };
    const auto a = at(0), b = at(1), c = at(2), d = at(3), e = at(4);
    hn::StoreU(Binomial(hn::And(a, low), hn::And(b, low), hn::And(c, low), hn::And(d, low), hn::And(e, low)), u32,
               even + i);
    hn::StoreU(Binomial(hn::ShiftRight<16>(a), hn::ShiftRight<16>(b), hn::ShiftRight<16>(c), hn::ShiftRight<16>(d),
                        hn::ShiftRight<16>(e)),
               u32, odd + i);
  });
  if (n % 2) {
    const int i = n - 1;
    even[pairs] = rows[0][i] + rows[4][i] + 4u * (rows[1][i] + rows[3][i]) + 6u * rows[2][i];
    odd[pairs] = odd[pairs - 1];
  }
  even[-1] = even[1];
  odd[-1] = odd[0];
  even[outputs] = even[mirrored(2 * outputs, n) / 2];
  const auto rounding = hn::Set(u32, 128);
  cover(outputs, u32, [&](int i) HWY_ATTR {
    const auto sum = Binomial(hn::LoadU(u32, even + i - 1), hn::LoadU(u32, odd + i - 1), hn::LoadU(u32, even + i),
                              hn::LoadU(u32, odd + i), hn::LoadU(u32, even + i + 1));
    const auto rounded = hn::ShiftRight<8>(hn::Add(sum, rounding));
    hn::StoreU(hn::DemoteTo(half_u16, hn::BitCast(i32, rounded)), half_u16, out + i);
  });
}

void MeanRow(const std::uint8_t *const rows[3], int n, std::uint16_t *scratch, std::uint8_t *out) {
  const int pairs = n / 2, outputs = (n + 1) / 2;
  if (pairs < lanes(u16)) return scalar::mean_row(rows, n, scratch, out);
  std::uint16_t *const even = scratch, *const odd = even + outputs + 1;
  const auto low = hn::Set(u16, 0xff);
  cover(pairs, u16, [&](int i) HWY_ATTR {
    const auto at = [&](int k) HWY_ATTR { return hn::BitCast(u16, hn::LoadU(u8, rows[k] + 2 * i)); };
    const auto a = at(0), b = at(1), c = at(2);
    hn::StoreU(Tent(hn::And(a, low), hn::And(b, low), hn::And(c, low)), u16, even + i);
    hn::StoreU(Tent(hn::ShiftRight<8>(a), hn::ShiftRight<8>(b), hn::ShiftRight<8>(c)), u16, odd + i);
  });
  if (n % 2) {
    even[pairs] = static_cast<std::uint16_t>(rows[0][n - 1] + 2 * rows[1][n - 1] + rows[2][n - 1]);
    odd[pairs] = odd[pairs - 1];
  }
  odd[-1] = odd[0];
  const auto rounding = hn::Set(u16, 8);
  cover(outputs, u16, [&](int i) HWY_ATTR {
    const auto sum = Tent(hn::LoadU(u16, odd + i - 1), hn::LoadU(u16, even + i), hn::LoadU(u16, odd + i));
    const auto rounded = hn::ShiftRight<4>(hn::Add(sum, rounding));
    hn::StoreU(hn::DemoteTo(half_u8, hn::BitCast(i16, rounded)), half_u8, out + i);
  });
}

#endif

void AddRow(const std::uint8_t *row, const std::uint8_t *forbidden, int n, std::uint16_t *sums, std::uint16_t *counts) {
  const int step = lanes(u16);
  const auto one = hn::Set(half_u8, 1);
  int i = 0;
  for (; i + step <= n; i += step) {
    const auto out = hn::LoadU(half_u8, forbidden + i);
    const auto value = hn::PromoteTo(u16, hn::AndNot(out, hn::LoadU(half_u8, row + i)));
    hn::StoreU(hn::Add(hn::LoadU(u16, sums + i), value), u16, sums + i);
    hn::StoreU(hn::Add(hn::LoadU(u16, counts + i), hn::PromoteTo(u16, hn::AndNot(out, one))), u16, counts + i);
  }
  scalar::add_row(row + i, forbidden + i, n - i, sums + i, counts + i);
}

void TissueRow(const std::uint8_t *const rows[3], const std::uint16_t *above, const std::uint16_t *below,
               std::uint16_t part, int n, std::uint16_t *scratch, std::uint8_t *out) {
  if (n < lanes(u16)) return scalar::tissue_row(rows, above, below, part, n, scratch, out);
  std::uint16_t *const sums = scratch + 1;
  cover(n, u16, [&](int i) HWY_ATTR {
    const auto at = [&](int k) HWY_ATTR { return hn::PromoteTo(u16, hn::LoadU(half_u8, rows[k] + i)); };
    hn::StoreU(Tent(at(0), at(1), at(2)), u16, sums + i);
  });
  for (const int i : {-1, n}) sums[i] = sums[mirrored(i, n)];
  const auto far = hn::Set(u16, static_cast<std::uint16_t>(65535 - part)), near = hn::Set(u16, part);
  const hn::RebindToSigned<decltype(half_u8)> half_i8;
  cover(n, u16, [&](int i) HWY_ATTR {
    const auto sum = Tent(hn::LoadU(u16, sums + i - 1), hn::LoadU(u16, sums + i), hn::LoadU(u16, sums + i + 1));
    const auto limit =
        hn::Add(hn::MulHigh(hn::LoadU(u16, above + i), far), hn::MulHigh(hn::LoadU(u16, below + i), near));
    // An unsigned comparison by saturation: AVX2 and SSE4 lack one for 16-bit words.
    const auto excess = hn::SaturatedSub(hn::ShiftLeft<4>(sum), limit);
    const auto tissue = hn::BitCast(i16, hn::VecFromMask(u16, hn::Eq(excess, hn::Zero(u16))));
    hn::StoreU(hn::BitCast(half_u8, hn::DemoteTo(half_i8, tissue)), half_u8, out + i);
  });
}

void ErodeRow(const std::uint8_t *const rows[5], const std::uint8_t *forbidden, int n, std::uint8_t *scratch,
              std::uint8_t *out) {
  if (n < lanes(u8)) return scalar::erode_row(rows, forbidden, n, scratch, out);
  std::uint8_t *const eroded = scratch + 2;
  cover(n, u8, [&](int i) HWY_ATTR {
    auto all = hn::LoadU(u8, rows[0] + i);
    for (int k = 1; k < 5; ++k) all = hn::And(all, hn::LoadU(u8, rows[k] + i));
    hn::StoreU(all, u8, eroded + i);
  });
  for (int k = 0; k < 2; ++k) scratch[k] = eroded[n + k] = 255;
  cover(n, u8, [&](int i) HWY_ATTR {
    auto all = hn::LoadU(u8, eroded + i);
    for (int k = 1; k <= 2; ++k)
      all = hn::And(all, hn::And(hn::LoadU(u8, eroded + i - k), hn::LoadU(u8, eroded + i + k)));
    all = hn::Or(all, hn::Set(u8, marked));
    hn::StoreU(hn::AndNot(hn::LoadU(u8, forbidden + i), all), u8, out + i);
  });
}

}  // namespace csd::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace csd {

HWY_EXPORT(SmoothRow);
HWY_EXPORT(ShrinkRow);
HWY_EXPORT(MeanRow);
HWY_EXPORT(AddRow);
HWY_EXPORT(TissueRow);
HWY_EXPORT(ErodeRow);

void smooth_row(const std::uint8_t *const rows[5], int n, std::uint16_t *scratch, std::uint16_t *out) {
  HWY_DYNAMIC_DISPATCH(SmoothRow)(rows, n, scratch, out);
}

void shrink_row(const std::uint16_t *const rows[5], int n, std::uint32_t *scratch, std::uint16_t *out) {
  HWY_DYNAMIC_DISPATCH(ShrinkRow)(rows, n, scratch, out);
}

void mean_row(const std::uint8_t *const rows[3], int n, std::uint16_t *scratch, std::uint8_t *out) {
  HWY_DYNAMIC_DISPATCH(MeanRow)(rows, n, scratch, out);
}

void add_row(const std::uint8_t *row, const std::uint8_t *forbidden, int n, std::uint16_t *sums,
             std::uint16_t *counts) {
  HWY_DYNAMIC_DISPATCH(AddRow)(row, forbidden, n, sums, counts);
}

void tissue_row(const std::uint8_t *const rows[3], const std::uint16_t *above, const std::uint16_t *below,
                std::uint16_t part, int n, std::uint16_t *scratch, std::uint8_t *out) {
  HWY_DYNAMIC_DISPATCH(TissueRow)(rows, above, below, part, n, scratch, out);
}

void erode_row(const std::uint8_t *const rows[5], const std::uint8_t *forbidden, int n, std::uint8_t *scratch,
               std::uint8_t *out) {
  HWY_DYNAMIC_DISPATCH(ErodeRow)(rows, forbidden, n, scratch, out);
}

namespace scalar {
namespace {

/// Weighted sum of 2·radius + 1 rows in one column.
template <class T>
std::uint32_t down(const T *const *rows, const int *weights, int radius, int x) {
  std::uint32_t sum = 0;
  for (int k = 0; k <= 2 * radius; ++k) sum += static_cast<std::uint32_t>(weights[k]) * rows[k][x];
  return sum;
}

/// The same along the row too, around a column.
template <class T>
std::uint32_t both(const T *const *rows, const int *weights, int radius, int x, int n) {
  std::uint32_t sum = 0;
  for (int k = 0; k <= 2 * radius; ++k)
    sum += static_cast<std::uint32_t>(weights[k]) * down(rows, weights, radius, mirrored(x + k - radius, n));
  return sum;
}

constexpr int binomial[] = {1, 4, 6, 4, 1}, tent[] = {1, 2, 1};

}  // namespace

void smooth_row(const std::uint8_t *const rows[5], int n, std::uint16_t *, std::uint16_t *out) {
  for (int x = 0; x < n; ++x) out[x] = static_cast<std::uint16_t>(both(rows, binomial, 2, x, n));
}

void shrink_row(const std::uint16_t *const rows[5], int n, std::uint32_t *, std::uint16_t *out) {
  for (int x = 0; x < n; x += 2) out[x / 2] = static_cast<std::uint16_t>((both(rows, binomial, 2, x, n) + 128) >> 8);
}

void mean_row(const std::uint8_t *const rows[3], int n, std::uint16_t *, std::uint8_t *out) {
  for (int x = 0; x < n; x += 2) out[x / 2] = static_cast<std::uint8_t>((both(rows, tent, 1, x, n) + 8) >> 4);
}

void add_row(const std::uint8_t *row, const std::uint8_t *forbidden, int n, std::uint16_t *sums,
             std::uint16_t *counts) {
  for (int x = 0; x < n; ++x) {
    sums[x] = static_cast<std::uint16_t>(sums[x] + (forbidden[x] ? 0 : row[x]));
    counts[x] = static_cast<std::uint16_t>(counts[x] + (forbidden[x] ? 0 : 1));
  }
}

void tissue_row(const std::uint8_t *const rows[3], const std::uint16_t *above, const std::uint16_t *below,
                std::uint16_t part, int n, std::uint16_t *, std::uint8_t *out) {
  const std::uint32_t near = part, far = 65535 - near;
  for (int x = 0; x < n; ++x) {
    const std::uint32_t limit = (above[x] * far >> 16) + (below[x] * near >> 16);
    out[x] = both(rows, tent, 1, x, n) << 4 > limit ? 0 : 255;
  }
}

void erode_row(const std::uint8_t *const rows[5], const std::uint8_t *forbidden, int n, std::uint8_t *,
               std::uint8_t *out) {
  for (int x = 0; x < n; ++x) {
    std::uint8_t eroded = 255;
    for (int k = 0; k < 5; ++k)
      for (int i = std::max(0, x - 2); i <= std::min(n - 1, x + 2); ++i) eroded = std::min(eroded, rows[k][i]);
    out[x] = forbidden[x] ? 0 : std::max(eroded, marked);
  }
}

}  // namespace scalar
}  // namespace csd
#endif
