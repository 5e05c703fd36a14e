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
/// Where samples are in a group of 12, three to a little-endian 32-bit word: the two bytes that hold each, and the
/// factor that shifts its upper bit to bit 15. Unused lanes repeat the first sample.
struct GroupTable {
  alignas(16) std::uint8_t bytes[16];
  alignas(16) std::uint16_t factor[8];
};
/// The three components of v210, U0 Y0 V0 Y1 U1 Y2 V1 Y3 U2 Y4 V2 Y5, and gray10.
inline constexpr int gray10_samples = 3;
constexpr int samples_of(const FrameView &view, int component) {
  return view.packing == Packing::v210 ? component : gray10_samples;
}
constexpr int group_position(int samples, int in_group) {
  return samples == gray10_samples ? in_group : samples == 0 ? 2 * in_group + 1 : 4 * in_group + (samples == 1 ? 0 : 2);
}
constexpr int per_group(int samples) {
  return samples == gray10_samples ? 12 : samples == 0 ? 6 : 3;
}
/// The table of eight samples, starting at the group's sample `first`.
constexpr GroupTable group_table(int samples, int first = 0) {
  GroupTable t{};
  for (int i = 0; i < 8; ++i) {
    const int position = group_position(samples, first + i < per_group(samples) ? first + i : 0);
    const int byte = 4 * (position / 3) + position % 3;  // bits 0, 10, 20 of a word are in its byte 0, 1, 2
    t.bytes[2 * i] = static_cast<std::uint8_t>(byte);
    t.bytes[2 * i + 1] = static_cast<std::uint8_t>(byte + 1);
    t.factor[i] = static_cast<std::uint16_t>(64 >> (2 * (position % 3)));  // starts at bit 0, 2, 4 of the two bytes
  }
  return t;
}
inline constexpr GroupTable group_tables[4] = {group_table(0), group_table(1), group_table(2),
                                               group_table(gray10_samples)};
inline constexpr GroupTable gray10_end = group_table(gray10_samples, 4);
}  // namespace csd
#endif

HWY_BEFORE_NAMESPACE();
namespace csd::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

// Each kernel converts as many of the `n` samples as whole vectors can without accesses past them, and returns their
// number; the scalar version converts the rest.

#if HWY_TARGET == HWY_SCALAR
int ReadGroups(const std::uint8_t *, int, int, std::uint8_t *) {
  return 0;
}
#else
/// `n` samples from the start of a group.
int ReadGroups(const std::uint8_t *group, int samples, int n, std::uint8_t *out) {
  const hn::Full128<std::uint8_t> d8;
  const hn::Full128<std::uint16_t> d16;
  const hn::RebindToSigned<decltype(d16)> signed16;
  const hn::Rebind<std::uint8_t, decltype(d16)> half;
  const auto two = hn::Set(d16, 2);
  const auto read = [&](const GroupTable &table, std::uint8_t *to) HWY_ATTR {
    const auto pairs = hn::BitCast(d16, hn::TableLookupBytes(hn::LoadU(d8, group), hn::Load(d8, table.bytes)));
    const auto sample = hn::ShiftRight<6>(hn::Mul(pairs, hn::Load(d16, table.factor)));
    const auto rounded = hn::ShiftRight<2>(hn::Add(sample, two));
    hn::StoreU(hn::DemoteTo(half, hn::BitCast(signed16, rounded)), half, to);
  };
  const int step = per_group(samples), written = std::max(step, 8);
  int x = 0;
  for (; x + written <= n; x += step, group += 16) {
    read(group_tables[samples], out + x);
    if (step > 8) read(gray10_end, out + x + 4);
  }
  return x;
}
#endif

const hn::ScalableTag<std::uint16_t> u16;
using Words = hn::Vec<decltype(u16)>;

/// Applies `byte_of`, clamped to 255, to 16-bit words that are 2, 4 or 8 bytes apart. If they are not contiguous, the
/// last one is left: its vector would end past the row.
template <class ByteOf>
HWY_INLINE int CoverWords(const std::uint8_t *p, std::ptrdiff_t stride, int n, std::uint8_t *out, ByteOf byte_of) {
  const hn::RebindToSigned<decltype(u16)> signed16;
  const hn::Rebind<std::uint8_t, decltype(u16)> half;
  const auto byte_max = hn::Set(u16, 255);
  const int lanes = static_cast<int>(hn::Lanes(u16)), whole = stride == 2 ? n : n - 1;
  if (whole < lanes) return 0;
  // Highway's scalar target reads words with a stride one by one, which C++ allows only if they are aligned (seen with
  // UBSan). Only odd strides give odd addresses.
  if (stride > 2 && reinterpret_cast<std::uintptr_t>(p) % sizeof(std::uint16_t) != 0) return 0;
  const auto words = reinterpret_cast<const std::uint16_t *>(p);
  const auto cover = [&](auto load) HWY_ATTR {
    const auto one = [&](int i) HWY_ATTR {
      hn::StoreU(hn::DemoteTo(half, hn::BitCast(signed16, hn::Min(byte_of(load(i)), byte_max))), half, out + i);
    };
    int i = 0;
    for (; i + lanes <= whole; i += lanes) one(i);
    if (i < whole) one(whole - lanes);
  };
  if (stride == 2) {
    cover([&](int i) HWY_ATTR { return hn::LoadU(u16, words + i); });
  } else if (stride == 4) {
    cover([&](int i) HWY_ATTR {
      Words a, b;
      hn::LoadInterleaved2(u16, words + 2 * i, a, b);
      return a;
    });
  } else {
    cover([&](int i) HWY_ATTR {
      Words a, b, c, e;
      hn::LoadInterleaved4(u16, words + 4 * i, a, b, c, e);
      return a;
    });
  }
  return whole;
}

int ReadWords(const std::uint8_t *p, const Component &c, int n, std::uint8_t *out) {
  const bool swapped = c.big_endian != (std::endian::native == std::endian::big);
  const auto ordered = [&](Words v)
                           HWY_ATTR { return swapped ? hn::Or(hn::ShiftLeft<8>(v), hn::ShiftRight<8>(v)) : v; };
  if (c.gain > 0) {
    const auto black = hn::Set(u16, c.black), gain = hn::Set(u16, c.gain);
    return CoverWords(p, c.pixel_stride, n, out,
                      [&](Words v) HWY_ATTR { return hn::MulHigh(hn::SaturatedSub(ordered(v), black), gain); });
  }
  const int shift = c.shift, left = c.left;
  const auto rounding = hn::Set(u16, static_cast<std::uint16_t>(1 << shift >> 1));
  if (!swapped && left == 0)
    return CoverWords(p, c.pixel_stride, n, out,
                      [&](Words v) HWY_ATTR { return hn::ShiftRightSame(hn::SaturatedAdd(v, rounding), shift); });
  return CoverWords(p, c.pixel_stride, n, out, [&](Words v) HWY_ATTR {
    return hn::ShiftRightSame(hn::SaturatedAdd(hn::ShiftLeftSame(ordered(v), left), rounding), shift);
  });
}

/// Bytes that are `stride` 2, 3 or 4 apart. The last pixel is left: its vector would end past the row.
int ReadBytes(const std::uint8_t *p, int stride, int n, std::uint8_t *out) {
  const hn::CappedTag<std::uint8_t, 32> d;
  const int lanes = static_cast<int>(hn::Lanes(d));
  if (n <= lanes) return 0;
  const auto cover = [&](auto load) HWY_ATTR {
    int i = 0;
    for (; i + lanes < n; i += lanes) hn::StoreU(load(i), d, out + i);
    // Once more for the remainder, except the last pixel.
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

std::uint8_t group_sample(const std::uint8_t *line, int samples, int index) {
  const std::uint8_t *group = line + 16 * static_cast<std::ptrdiff_t>(index / per_group(samples));
  const int position = group_position(samples, index % per_group(samples));
  const std::uint32_t sample = little_endian_32(group + 4 * (position / 3)) >> (10 * (position % 3)) & 0x3ff;
  return static_cast<std::uint8_t>(std::min<std::uint32_t>((sample + 2) >> 2, 255));
}

/// Index of the view's sample `first` in its row, which starts with a group.
int in_groups(const FrameView &view, int component, int first) {
  return first + (component == 0 ? view.x_offset : view.x_offset >> 1);
}

std::uint8_t word_sample(const std::uint8_t *p, const Component &c) {
  const unsigned word = c.big_endian ? unsigned{p[0]} << 8 | p[1] : p[0] | unsigned{p[1]} << 8;
  if (c.gain > 0)
    return static_cast<std::uint8_t>(std::min((std::max<unsigned>(word, c.black) - c.black) * c.gain >> 16, 255u));
  const unsigned sample = (word << c.left) & 0xffff;
  return static_cast<std::uint8_t>(std::min((sample + (1u << c.shift >> 1)) >> c.shift, 255u));
}

/// Samples [first, first + n) of a component in a row, without SIMD.
void read_slowly(const FrameView &view, int component, int row, int first, int n, std::uint8_t *out) {
  if (view.packing != Packing::components) {
    const Component &c = view.component[0];
    first = in_groups(view, component, first);
    for (int i = 0; i < n; ++i)
      out[i] = group_sample(c.data + row * c.row_stride, samples_of(view, component), first + i);
    return;
  }
  const Component &c = view.component[component];
  const std::uint8_t *p = c.data + row * c.row_stride + first * c.pixel_stride;
  for (int i = 0; i < n; ++i, p += c.pixel_stride) out[i] = c.bytes == 1 ? *p : word_sample(p, c);
}

}  // namespace

void read_samples(const FrameView &view, int row, int first, int n, const std::array<std::uint8_t *, 3> &out) {
  if (view.reader) return view.reader->read(row, first, n, out);
  for (int k = 0; k < 3; ++k)
    if (std::uint8_t *to = out[static_cast<std::size_t>(k)]) read_samples(view, k, row, first, n, to);
}

void read_samples(const FrameView &view, int component, int row, int first, int n, std::uint8_t *out) {
  if (view.reader) {
    std::array<std::uint8_t *, 3> one{};
    one[static_cast<std::size_t>(component)] = out;
    return view.reader->read(row, first, n, one);
  }
  int done = 0;
  if (view.packing != Packing::components) {
    const Component &c = view.component[0];
    const int samples = samples_of(view, component), step = per_group(samples), at = in_groups(view, component, first);
    done = std::min(n, (step - at % step) % step);
    read_slowly(view, component, row, first, done, out);
    const std::uint8_t *group = c.data + row * c.row_stride + 16 * static_cast<std::ptrdiff_t>((at + done) / step);
    done += HWY_DYNAMIC_DISPATCH(ReadGroups)(group, samples, n - done, out + done);
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
    else if (c.bytes == 2 && (stride == 2 || stride == 4 || stride == 8))
      done = HWY_DYNAMIC_DISPATCH(ReadWords)(p, c, n, out);
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
