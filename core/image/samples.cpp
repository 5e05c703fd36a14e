// SPDX-License-Identifier: LGPL-2.1-or-later
#include "image/samples.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "image/samples.cpp"
#include <hwy/foreach_target.h>
// After foreach_target.
#include <hwy/highway.h>

#include <algorithm>
#include <bit>
#include <cstring>

#ifndef CSD_SAMPLES_ONCE
#define CSD_SAMPLES_ONCE
namespace csd {
/// Where a component's samples lie in a v210 group of 12, three to a little-endian 32-bit word, in the order
/// U0 Y0 V0 Y1 U1 Y2 V1 Y3 U2 Y4 V2 Y5: bytes of the two that hold each, and the factor that shifts its upper bit to
/// bit 15. Lanes that no sample needs repeat the first.
struct V210Table {
  alignas(16) std::uint8_t bytes[16];
  alignas(16) std::uint16_t factor[8];
};
constexpr int v210_position(int component, int in_group) {
  return component == 0 ? 2 * in_group + 1 : 4 * in_group + (component == 1 ? 0 : 2);
}
constexpr int v210_per_group(int component) {
  return component == 0 ? 6 : 3;
}
constexpr V210Table v210_table(int component) {
  V210Table t{};
  for (int i = 0; i < 8; ++i) {
    const int position = v210_position(component, i < v210_per_group(component) ? i : 0);
    const int byte = 4 * (position / 3) + position % 3;  // bits 0, 10, 20 of a word begin in its byte 0, 1, 2
    t.bytes[2 * i] = static_cast<std::uint8_t>(byte);
    t.bytes[2 * i + 1] = static_cast<std::uint8_t>(byte + 1);
    t.factor[i] = static_cast<std::uint16_t>(64 >> (2 * (position % 3)));  // at bit 0, 2, 4 of the two bytes
  }
  return t;
}
inline constexpr V210Table v210_tables[3] = {v210_table(0), v210_table(1), v210_table(2)};
}  // namespace csd
#endif

HWY_BEFORE_NAMESPACE();
namespace csd::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

// Each kernel does as many samples of `n` as whole vectors give without reading or writing past them, and says how
// many; the scalar twin does the rest.

#if HWY_TARGET == HWY_SCALAR
int ReadGroups(const std::uint8_t *, int, int, std::uint8_t *) {
  return 0;
}
#else
/// `n` samples of a component from the first of a v210 group on.
int ReadGroups(const std::uint8_t *group, int component, int n, std::uint8_t *out) {
  const hn::Full128<std::uint8_t> d8;
  const hn::Full128<std::uint16_t> d16;
  const hn::RebindToSigned<decltype(d16)> signed16;
  const hn::Rebind<std::uint8_t, decltype(d16)> half;
  const auto table = hn::Load(d8, v210_tables[component].bytes);
  const auto factor = hn::Load(d16, v210_tables[component].factor);
  const auto two = hn::Set(d16, 2);
  const int step = v210_per_group(component);
  int x = 0;
  for (; x + 8 <= n; x += step, group += 16) {  // 8 are written, `step` count
    const auto pairs = hn::BitCast(d16, hn::TableLookupBytes(hn::LoadU(d8, group), table));
    const auto sample = hn::ShiftRight<6>(hn::Mul(pairs, factor));
    const auto rounded = hn::ShiftRight<2>(hn::Add(sample, two));
    hn::StoreU(hn::DemoteTo(half, hn::BitCast(signed16, rounded)), half, out + x);
  }
  return x;
}
#endif

/// 16-bit words, `stride` 2 or 4 bytes apart, of a machine that stores them as the picture does.
int ReadWords(const std::uint8_t *p, int stride, int shift, int n, std::uint8_t *out) {
  const hn::ScalableTag<std::uint16_t> d;
  const hn::RebindToSigned<decltype(d)> signed16;
  const hn::Rebind<std::uint8_t, decltype(d)> half;
  const int lanes = static_cast<int>(hn::Lanes(d));
  const auto rounding = hn::Set(d, static_cast<std::uint16_t>(1 << shift >> 1)), most = hn::Set(d, 255);
  const auto words = reinterpret_cast<const std::uint16_t *>(p);
  const auto store = [&](auto v, int i) HWY_ATTR {
    const auto rounded = hn::Min(hn::ShiftRightSame(hn::SaturatedAdd(v, rounding), shift), most);
    hn::StoreU(hn::DemoteTo(half, hn::BitCast(signed16, rounded)), half, out + i);
  };
  int i = 0;
  if (stride == 2) {
    for (; i + lanes <= n; i += lanes) store(hn::LoadU(d, words + i), i);
  } else {
    for (; i + lanes < n; i += lanes) {
      hn::Vec<decltype(d)> a, b;
      hn::LoadInterleaved2(d, words + 2 * i, a, b);
      store(a, i);
    }
  }
  return i;
}

/// Bytes, `stride` 2, 3 or 4 apart. The last pixel is left: its vector would end past the row.
int ReadBytes(const std::uint8_t *p, int stride, int n, std::uint8_t *out) {
  const hn::CappedTag<std::uint8_t, 32> d;
  const int lanes = static_cast<int>(hn::Lanes(d));
  if (n <= lanes) return 0;
  const auto cover = [&](auto load) HWY_ATTR {
    int i = 0;
    for (; i + lanes < n; i += lanes) hn::StoreU(load(i), d, out + i);
    // Once more for what is left, so that one pixel stays.
    hn::StoreU(load(n - 1 - lanes), d, out + n - 1 - lanes);
  };
  hn::Vec<decltype(d)> a, b, c, e;
  if (stride == 2) {
    cover([&](int i) HWY_ATTR {
      hn::LoadInterleaved2(d, p + 2 * i, a, b);
      return a;
    });
  } else if (stride == 3) {
    cover([&](int i) HWY_ATTR {
      hn::LoadInterleaved3(d, p + 3 * i, a, b, c);
      return a;
    });
  } else {
    cover([&](int i) HWY_ATTR {
      hn::LoadInterleaved4(d, p + 4 * i, a, b, c, e);
      return a;
    });
  }
  return n - 1;
}

}  // namespace csd::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace csd {

HWY_EXPORT(ReadGroups);
HWY_EXPORT(ReadWords);
HWY_EXPORT(ReadBytes);

namespace {

std::uint32_t little_endian_32(const std::uint8_t *p) {
  return p[0] | static_cast<std::uint32_t>(p[1]) << 8 | static_cast<std::uint32_t>(p[2]) << 16 |
         static_cast<std::uint32_t>(p[3]) << 24;
}

std::uint8_t v210_sample(const std::uint8_t *line, int component, int index) {
  const std::uint8_t *group = line + 16 * static_cast<std::ptrdiff_t>(index / v210_per_group(component));
  const int position = v210_position(component, index % v210_per_group(component));
  const std::uint32_t sample = little_endian_32(group + 4 * (position / 3)) >> (10 * (position % 3)) & 0x3ff;
  return static_cast<std::uint8_t>(std::min<std::uint32_t>((sample + 2) >> 2, 255));
}

/// Samples [first, first + n) of a component in a row without SIMD.
void read_slowly(const FrameView &view, int component, int row, int first, int n, std::uint8_t *out) {
  if (view.packing == Packing::v210) {
    const Component &c = view.component[0];
    first += component == 0 ? view.x_offset : view.x_offset >> 1;
    for (int i = 0; i < n; ++i) out[i] = v210_sample(c.data + row * c.row_stride, component, first + i);
    return;
  }
  const Component &c = view.component[component];
  const std::uint8_t *p = c.data + row * c.row_stride + first * c.pixel_stride;
  const int half = 1 << c.shift >> 1;
  for (int i = 0; i < n; ++i, p += c.pixel_stride)
    out[i] = c.bytes == 1 ? *p : static_cast<std::uint8_t>(std::min(((p[0] | p[1] << 8) + half) >> c.shift, 255));
}

}  // namespace

void read_samples(const FrameView &view, int component, int row, int first, int n, std::uint8_t *out) {
  int done = 0;
  if (view.packing == Packing::v210) {
    const Component &c = view.component[0];
    const int per_group = v210_per_group(component), at = first + (component == 0 ? view.x_offset : view.x_offset >> 1);
    done = std::min(n, (per_group - at % per_group) % per_group);
    read_slowly(view, component, row, first, done, out);
    const std::uint8_t *group = c.data + row * c.row_stride + 16 * static_cast<std::ptrdiff_t>((at + done) / per_group);
    done += HWY_DYNAMIC_DISPATCH(ReadGroups)(group, component, n - done, out + done);
  } else {
    const Component &c = view.component[component];
    const std::uint8_t *p = c.data + row * c.row_stride + first * c.pixel_stride;
    const auto stride = static_cast<int>(c.pixel_stride);
    if (c.bytes == 1 && stride == 1) {
      std::memcpy(out, p, static_cast<std::size_t>(n));
      return;
    }
    if (c.bytes == 1 && stride >= 2 && stride <= 4)
      done = HWY_DYNAMIC_DISPATCH(ReadBytes)(p, stride, n, out);
    else if (c.bytes == 2 && (stride == 2 || stride == 4) && std::endian::native == std::endian::little)
      done = HWY_DYNAMIC_DISPATCH(ReadWords)(p, stride, c.shift, n, out);
  }
  read_slowly(view, component, row, first + done, n - done, out + done);
}

namespace scalar {

void read_samples(const FrameView &view, int component, int row, int first, int n, std::uint8_t *out) {
  read_slowly(view, component, row, first, n, out);
}

}  // namespace scalar
}  // namespace csd
#endif
