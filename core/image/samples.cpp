// SPDX-License-Identifier: LGPL-2.1-or-later
#include "image/samples.h"

#include <algorithm>
#include <cstring>

namespace csd {
namespace {

std::uint32_t little_endian_32(const std::uint8_t *p) {
  return p[0] | static_cast<std::uint32_t>(p[1]) << 8 | static_cast<std::uint32_t>(p[2]) << 16 |
         static_cast<std::uint32_t>(p[3]) << 24;
}

std::uint8_t round_10(std::uint32_t sample) {
  return static_cast<std::uint8_t>(std::min<std::uint32_t>(((sample & 0x3ff) + 2) >> 2, 255));
}

/// The 12 samples of a v210 group lie in the order U0 Y0 V0 Y1 U1 Y2 V1 Y3 U2 Y4 V2 Y5, three to a 32-bit word.
std::uint8_t v210_sample(const std::uint8_t *line, int component, int index) {
  const int per_group = component == 0 ? 6 : 3;
  const std::uint8_t *group = line + 16 * static_cast<std::ptrdiff_t>(index / per_group);
  const int in_group = index % per_group;
  const int position = component == 0 ? 2 * in_group + 1 : 4 * in_group + (component == 1 ? 0 : 2);
  return round_10(little_endian_32(group + 4 * (position / 3)) >> (10 * (position % 3)));
}

void read_v210(const std::uint8_t *line, int component, int first, int n, std::uint8_t *out) {
  const int last = first + n;
  int x = first;
  if (component == 0) {
    for (; x < last && x % 6 != 0; ++x) *out++ = v210_sample(line, 0, x);
    for (; x + 6 <= last; x += 6, out += 6) {
      const std::uint8_t *group = line + 16 * static_cast<std::ptrdiff_t>(x / 6);
      const std::uint32_t w0 = little_endian_32(group), w1 = little_endian_32(group + 4);
      const std::uint32_t w2 = little_endian_32(group + 8), w3 = little_endian_32(group + 12);
      out[0] = round_10(w0 >> 10);
      out[1] = round_10(w1);
      out[2] = round_10(w1 >> 20);
      out[3] = round_10(w2 >> 10);
      out[4] = round_10(w3);
      out[5] = round_10(w3 >> 20);
    }
  }
  for (; x < last; ++x) *out++ = v210_sample(line, component, x);
}

void read_words(const std::uint8_t *p, std::ptrdiff_t stride, int shift, int n, std::uint8_t *out) {
  const int half = shift > 0 ? 1 << (shift - 1) : 0;
  for (int i = 0; i < n; ++i, p += stride)
    out[i] = static_cast<std::uint8_t>(std::min(((p[0] | p[1] << 8) + half) >> shift, 255));
}

/// The stride as a constant lets the compiler turn the loop into shuffles.
template <int stride>
void read_bytes(const std::uint8_t *p, int n, std::uint8_t *out) {
  for (int i = 0; i < n; ++i) out[i] = p[static_cast<std::ptrdiff_t>(i) * stride];
}

}  // namespace

void read_samples(const FrameView &view, int component, int row, int first, int n, std::uint8_t *out) {
  if (view.packing == Packing::v210) {
    const Component &c = view.component[0];
    const int offset = component == 0 ? view.x_offset : view.x_offset >> 1;
    return read_v210(c.data + row * c.row_stride, component, first + offset, n, out);
  }
  const Component &c = view.component[component];
  const std::uint8_t *p = c.data + row * c.row_stride + first * c.pixel_stride;
  if (c.bytes == 2) return read_words(p, c.pixel_stride, c.shift, n, out);
  switch (c.pixel_stride) {
    case 1:
      std::memcpy(out, p, static_cast<std::size_t>(n));
      return;
    case 2:
      return read_bytes<2>(p, n, out);
    case 3:
      return read_bytes<3>(p, n, out);
    case 4:
      return read_bytes<4>(p, n, out);
    default:
      for (int i = 0; i < n; ++i, p += c.pixel_stride) out[i] = *p;
  }
}

}  // namespace csd
