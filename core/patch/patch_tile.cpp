// SPDX-License-Identifier: LGPL-2.1-or-later
#include "patch/patch_tile.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "patch/patch_tile.cpp"
#include <hwy/foreach_target.h>
// After foreach_target.
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace csd {
namespace HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

#if HWY_TARGET == HWY_SCALAR  // below SSSE3

void PairRows(const std::uint16_t *rows, std::size_t stride, std::size_t n, int height, std::uint32_t *out) {
  for (int y = 0; y < height; ++y, rows += stride, out += PatchTile::side)
    for (std::size_t i = 0; i < n; ++i) out[i] = rows[i] | static_cast<std::uint32_t>(rows[i + stride]) << 16;
}

void SampleTile(const std::uint32_t *tile, const float *map, float scale, float *out) {
  for (std::size_t i = 0; i < PatchPlane::size; ++i) {
    const auto k = static_cast<float>(i / patch_lanes::period);
    const float vx = patch_lanes::x[i % patch_lanes::period], vy = patch_lanes::y[i % patch_lanes::period] + 2 * k;
    const float x = map[0] + map[2] * vx + map[3] * vy, y = map[1] + map[4] * vx + map[5] * vy;
    const auto ix = static_cast<int>(x), iy = static_cast<int>(y);
    const float fx = x - static_cast<float>(ix), fy = y - static_cast<float>(iy);
    const std::uint32_t *p = tile + iy * PatchTile::side + ix;
    const auto column = [&](std::uint32_t word) {
      const auto above = static_cast<float>(word & 0xffff), below = static_cast<float>(word >> 16);
      return above + fy * (below - above);
    };
    out[i] = scale * (column(p[0]) + fx * (column(p[1]) - column(p[0])));
  }
}

#else

using patch_lanes::period;
using Floats = hn::CappedTag<float, 16>;
using V = hn::Vec<Floats>;

// n: a multiple of 16. Reads height + 1 rows.
void PairRows(const std::uint16_t *HWY_RESTRICT rows, std::size_t stride, std::size_t n, int height,
              std::uint32_t *HWY_RESTRICT out) {
  const hn::CappedTag<std::uint32_t, 16> d;
  const hn::Rebind<std::uint16_t, decltype(d)> d16;
  for (std::size_t i = 0; i < n; i += hn::Lanes(d)) {
    const std::uint16_t *in = rows + i;
    auto above = hn::PromoteTo(d, hn::LoadU(d16, in));
    for (int y = 0; y < height; ++y) {
      const auto below = hn::PromoteTo(d, hn::LoadU(d16, in += stride));
      hn::Store(hn::Or(above, hn::ShiftLeft<16>(below)), d, out + i + y * PatchTile::side);
      above = below;
    }
  }
}

// Interpolates a column of two pixels, one 32-bit word, at `f` of the way down.
HWY_INLINE V Column(Floats d, hn::Vec<hn::RebindToSigned<Floats>> word, V f) {
  const hn::RebindToSigned<Floats> di;
  const auto above = hn::ConvertTo(d, hn::And(word, hn::Set(di, 0xffff)));
  const hn::RebindToUnsigned<Floats> du;
  const auto below = hn::ConvertTo(d, hn::BitCast(di, hn::ShiftRight<16>(hn::BitCast(du, word))));
  return hn::MulAdd(f, hn::Sub(below, above), above);
}

// map: x and y of the patch's centre, then `step` in row-major order, in tile coordinates: none is negative.
void SampleTile(const std::uint32_t *HWY_RESTRICT tile, const float *HWY_RESTRICT map, float scale,
                float *HWY_RESTRICT out) {
  const Floats d;
  const hn::RebindToSigned<Floats> di;
  const auto *words = reinterpret_cast<const std::int32_t *>(tile);
  const V xx = hn::Set(d, map[2]), xy = hn::Set(d, map[3]), yx = hn::Set(d, map[4]), yy = hn::Set(d, map[5]);
  const V next_x = hn::Set(d, 2 * map[3]), next_y = hn::Set(d, 2 * map[5]), vscale = hn::Set(d, scale);
  for (std::size_t j = 0; j < period; j += hn::Lanes(d)) {
    const V vx = hn::Load(d, patch_lanes::x + j), vy = hn::Load(d, patch_lanes::y + j);
    V x = hn::MulAdd(xx, vx, hn::MulAdd(xy, vy, hn::Set(d, map[0])));
    V y = hn::MulAdd(yx, vx, hn::MulAdd(yy, vy, hn::Set(d, map[1])));
    for (std::size_t i = j; i < PatchPlane::size; i += period) {
      const auto ix = hn::ConvertTo(di, x), iy = hn::ConvertTo(di, y);
      const V fx = hn::Sub(x, hn::ConvertTo(d, ix)), fy = hn::Sub(y, hn::ConvertTo(d, iy));
      const auto at = hn::Add(hn::ShiftLeft<6>(iy), ix);
#if HWY_ARCH_X86 && HWY_TARGET <= HWY_AVX2
      // One 64-bit gather loads both columns of a sample, which halves the loads.
      const hn::Repartition<std::int64_t, Floats> d64;
      const auto bytes = hn::BitCast(d64, hn::ShiftLeft<2>(at));
      const auto *base = reinterpret_cast<const std::int64_t *>(tile);
      const auto even = hn::GatherOffset(d64, base, hn::And(bytes, hn::Set(d64, 0xffffffff)));
      const auto odd = hn::GatherOffset(d64, base, hn::ShiftRight<32>(bytes));
      const auto left = hn::OddEven(hn::BitCast(di, hn::ShiftLeft<32>(odd)), hn::BitCast(di, even));
      const auto right = hn::OddEven(hn::BitCast(di, odd), hn::BitCast(di, hn::ShiftRight<32>(even)));
#else
      const auto left = hn::GatherIndex(di, words, at);
      const auto right = hn::GatherIndex(di, words + 1, at);
#endif
      const V a = Column(d, left, fy), b = Column(d, right, fy);
      hn::Store(hn::Mul(vscale, hn::MulAdd(fx, hn::Sub(b, a), a)), d, out + i);
      x = hn::Add(x, next_x);
      y = hn::Add(y, next_y);
    }
  }
  static_cast<void>(words);
}

#endif

}  // namespace HWY_NAMESPACE
}  // namespace csd
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace csd {

HWY_EXPORT(PairRows);
HWY_EXPORT(SampleTile);

namespace {

constexpr int max_rows = PatchTile::side + 1;  // of the source of a tile

/// Copies n pixels in each of `height` rows of PatchTile::side, from (left, top) on, with the border replicated.
template <class T>
void copy_rows(const cv::Mat &m, int left, int top, std::size_t n, int height, std::uint16_t *out) {
  for (int y = 0; y < height; ++y, out += PatchTile::side) {
    const T *row = m.ptr<T>(std::clamp(top + y, 0, m.rows - 1));
    if (left >= 0 && left + static_cast<int>(n) <= m.cols)
      std::copy_n(row + left, n, out);
    else
      for (int x = 0; x < static_cast<int>(n); ++x) out[x] = row[std::clamp(left + x, 0, m.cols - 1)];
  }
}

bool all_255(const std::uint8_t *bytes, int size) {
  if (size < 8) return std::all_of(bytes, bytes + size, [](std::uint8_t b) { return b == 255; });
  std::uint64_t all = ~std::uint64_t{0}, word = 0;
  for (int i = 0; i < size; i += 8) {
    std::memcpy(&word, bytes + std::min(i, size - 8), sizeof word);
    all &= word;
  }
  return all == ~std::uint64_t{0};
}

template <class T>
double bilinear(const cv::Mat &m, double x, double y) {
  const int x0 = std::clamp(static_cast<int>(x), 0, m.cols - 2), y0 = std::clamp(static_cast<int>(y), 0, m.rows - 2);
  const double fx = x - x0, fy = y - y0;
  const T *a = m.ptr<T>(y0) + x0, *b = m.ptr<T>(y0 + 1) + x0;
  return (a[0] + fx * (a[1] - a[0])) * (1 - fy) + (b[0] + fx * (b[1] - b[0])) * fy;
}

}  // namespace

bool prepare_tile(const cv::Mat &level, const cv::Mat &weights, const PatchMap &map, PatchTile &tile) {
  constexpr double rx = PatchPlane::radius, ry = PatchPlane::rows - 1 - PatchPlane::radius;  // includes the padding
  const double ex = rx * std::abs(map.step(0, 0)) + ry * std::abs(map.step(0, 1));
  const double ey = rx * std::abs(map.step(1, 0)) + ry * std::abs(map.step(1, 1));
  if (!(ex < PatchTile::side && ey < PatchTile::side)) return false;
  int left = static_cast<int>(std::floor(map.origin.x - ex)),
      right = static_cast<int>(std::floor(map.origin.x + ex)) + 2;
  int top = static_cast<int>(std::floor(map.origin.y - ey)), low = static_cast<int>(std::floor(map.origin.y + ey)) + 2;
  if (tile.width && left >= tile.x0 && top >= tile.y0 && right <= tile.x0 + tile.width && low <= tile.y0 + tile.height)
    return true;
  constexpr int margin = 2;
  if (right - left > PatchTile::side || low - top > PatchTile::side) return false;
  if (right - left + 2 * margin <= PatchTile::side) left -= margin, right += margin;
  if (low - top + 2 * margin <= PatchTile::side) top -= margin, low += margin;
  tile.x0 = left, tile.y0 = top, tile.width = right - left, tile.height = low - top;
  tile.right = level.cols - 1 - left, tile.bottom = level.rows - 1 - top;

  const auto pair_rows = HWY_DYNAMIC_DISPATCH(PairRows);
  const auto n = static_cast<std::size_t>((tile.width + 15) / 16 * 16);
  const int rows = tile.height + 1;
  alignas(64) std::uint16_t buffer[max_rows * PatchTile::side];
  if (left >= 0 && top >= 0 && left + static_cast<int>(n) <= level.cols && top + rows <= level.rows) {
    pair_rows(level.ptr<std::uint16_t>(top) + left, level.step1(), n, tile.height, tile.pixels);
  } else {
    copy_rows<std::uint16_t>(level, left, top, n, rows, buffer);
    pair_rows(buffer, PatchTile::side, n, tile.height, tile.pixels);
  }

  tile.within = left >= 0 && top >= 0 && right <= level.cols && low <= level.rows;
  tile.plain = tile.within;
  if (weights.empty()) {
    if (tile.plain) return true;
    std::fill_n(buffer, rows * PatchTile::side, std::uint16_t{255});
  } else {
    for (int y = top; tile.plain && y < low; ++y) tile.plain = all_255(weights.ptr(y) + left, tile.width);
    if (tile.plain) return true;
    copy_rows<std::uint8_t>(weights, left, top, n, rows, buffer);
  }
  pair_rows(buffer, PatchTile::side, n, tile.height, tile.weights);
  return true;
}

double sample_tile(const PatchTile &tile, const PatchMap &map, PatchPlane &value, PatchPlane &weight) {
  const auto run = HWY_DYNAMIC_DISPATCH(SampleTile);
  const float m[6] = {static_cast<float>(map.origin.x - tile.x0), static_cast<float>(map.origin.y - tile.y0),
                      static_cast<float>(map.step(0, 0)),         static_cast<float>(map.step(0, 1)),
                      static_cast<float>(map.step(1, 0)),         static_cast<float>(map.step(1, 1))};
  run(tile.pixels, m, 1.F / 256, value.data.data());
  if (tile.plain) return 1;
  run(tile.weights, m, 1.F / 255, weight.data.data());
  if (tile.within) return 1;
  int inside = 0;
  for (int vy = -PatchPlane::radius; vy <= PatchPlane::radius; ++vy)
    for (int vx = -PatchPlane::radius; vx <= PatchPlane::radius; ++vx) {
      const double x = map.origin.x - tile.x0 + map.step(0, 0) * vx + map.step(0, 1) * vy;
      const double y = map.origin.y - tile.y0 + map.step(1, 0) * vx + map.step(1, 1) * vy;
      const bool in = x >= -tile.x0 - inside_tolerance && y >= -tile.y0 - inside_tolerance &&
                      x <= tile.right + inside_tolerance && y <= tile.bottom + inside_tolerance;
      if (!in) weight.at(vx, vy) = 0;
      inside += in;
    }
  return static_cast<double>(inside) / PatchPlane::pixels;
}

double sample_scalar(const cv::Mat &level, const cv::Mat &weights, const PatchMap &map, PatchPlane &value,
                     PatchPlane &weight) {
  int inside = 0;
  const double right = level.cols - 1, bottom = level.rows - 1;
  PatchPlane::for_each_sample([&](int vx, int vy, std::size_t i) {
    const double x = map.origin.x + map.step(0, 0) * vx + map.step(0, 1) * vy;
    const double y = map.origin.y + map.step(1, 0) * vx + map.step(1, 1) * vy;
    const bool in = x >= -inside_tolerance && y >= -inside_tolerance && x <= right + inside_tolerance &&
                    y <= bottom + inside_tolerance;
    const double cx = std::clamp(x, 0., right), cy = std::clamp(y, 0., bottom);
    value.data[i] = static_cast<float>(bilinear<std::uint16_t>(level, cx, cy) / 256);
    weight.data[i] = !in               ? 0.F
                     : weights.empty() ? 1.F
                                       : static_cast<float>(bilinear<std::uint8_t>(weights, cx, cy) / 255);
    inside += in;
  });
  return static_cast<double>(inside) / PatchPlane::pixels;
}

}  // namespace csd
#endif  // HWY_ONCE
