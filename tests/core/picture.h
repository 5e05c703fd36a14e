// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <opencv2/core.hpp>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include "image/frame_view.h"

namespace csd::test {

/// A smooth random picture without end: cubic B-splines over lattices of random values at two sizes. It can be rendered
/// at any sub-pixel shift without resampling.
class Texture {
 public:
  explicit Texture(std::uint32_t seed) : seed_(seed) {}

  /// 0…255, at any point, for a channel.
  double at(double x, double y, int channel) const {
    const auto layer = static_cast<std::uint32_t>(channel);
    const double value = 0.6 * spline(x / 11, y / 11, 2 * layer) + 0.4 * spline(x / 4.5, y / 4.5, 2 * layer + 1);
    return std::clamp(127.5 + 300 * (value - 0.5), 0.0, 255.0);
  }

  /// CV_8UC3, B G R: pixel (x, y) shows the texture at (x − shift.x, y − shift.y), so content moves by +shift.
  cv::Mat render(cv::Size size, cv::Point2d shift = {}) const {
    cv::Mat bgr(size, CV_8UC3);
    for (int y = 0; y < size.height; ++y)
      for (int x = 0; x < size.width; ++x)
        for (int c = 0; c < 3; ++c)
          bgr.ptr(y)[3 * x + c] = static_cast<std::uint8_t>(std::lround(at(x - shift.x, y - shift.y, c)));
    return bgr;
  }

 private:
  double lattice(int x, int y, std::uint32_t layer) const {
    std::uint32_t h = seed_ + layer * 0x9e3779b9u;
    for (const int v : {x, y}) {
      h ^= static_cast<std::uint32_t>(v) * 0x85ebca6bu;
      h ^= h >> 15;
      h *= 0x2c1b3c6du;
      h ^= h >> 13;
    }
    h *= 0x297a2d39u;
    return static_cast<double>(h >> 8) / (1 << 24);
  }

  double spline(double x, double y, std::uint32_t layer) const {
    const int ix = static_cast<int>(std::floor(x)), iy = static_cast<int>(std::floor(y));
    const auto weights = [](double f, double(&w)[4]) {
      w[0] = (1 - f) * (1 - f) * (1 - f) / 6;
      w[1] = (3 * f * f * f - 6 * f * f + 4) / 6;
      w[2] = (-3 * f * f * f + 3 * f * f + 3 * f + 1) / 6;
      w[3] = f * f * f / 6;
    };
    double wx[4], wy[4], sum = 0;
    weights(x - ix, wx);
    weights(y - iy, wy);
    for (int j = 0; j < 4; ++j)
      for (int i = 0; i < 4; ++i) sum += wx[i] * wy[j] * lattice(ix + i - 1, iy + j - 1, layer);
    return sum;
  }

  std::uint32_t seed_;
};

enum class Layout {
  gray8,
  gray10_le32,
  gray16_le,
  i420,
  yv12,
  nv12,
  nv21,
  nv16,
  y42b,
  y444,
  yuy2,
  uyvy,
  vuya,
  v210,
  i420_10le,
  i422_10le,
  y444_10le,
  p010_10le,
  y210,
  y410,
  i420_12le,
  p012_le,
  rgb,
  bgr,
  rgbx,
  bgrx,
  xrgb,
  xbgr,
  r210,
  bgr10a2_le,
  rgba64_le,
  argb64_le
};

inline constexpr Layout all_layouts[] = {
    Layout::gray8,     Layout::gray10_le32, Layout::gray16_le, Layout::i420,      Layout::yv12,      Layout::nv12,
    Layout::nv21,      Layout::nv16,        Layout::y42b,      Layout::y444,      Layout::yuy2,      Layout::uyvy,
    Layout::vuya,      Layout::v210,        Layout::i420_10le, Layout::i422_10le, Layout::y444_10le, Layout::p010_10le,
    Layout::y210,      Layout::y410,        Layout::i420_12le, Layout::p012_le,   Layout::rgb,       Layout::bgr,
    Layout::rgbx,      Layout::bgrx,        Layout::xrgb,      Layout::xbgr,      Layout::r210,      Layout::bgr10a2_le,
    Layout::rgba64_le, Layout::argb64_le};

constexpr bool is_gray(Layout l) {
  return l <= Layout::gray16_le;
}
constexpr bool is_rgb(Layout l) {
  return l >= Layout::rgb;
}
constexpr int depth_of(Layout l) {
  using enum Layout;
  if (l == gray16_le || l == rgba64_le || l == argb64_le) return 16;
  if (l == i420_12le || l == p012_le) return 12;
  return l == gray10_le32 || (l >= v210 && l <= y410) || l == r210 || l == bgr10a2_le ? 10 : 8;
}

/// A picture in memory and a view of it. The buffer ends with the last sample, so that a sanitizer sees a read beyond
/// it.
struct Packed {
  std::vector<std::uint8_t> bytes;
  FrameView view;

  Packed() = default;
  // The view points into the buffer, which only a move keeps in place.
  Packed(Packed &&) = default;
  Packed &operator=(Packed &&) = default;
};

/// Y, U or V of B G R (BT.709, 16…235/240), 0…255, not rounded. U and V are averaged over 2^sub_x × 2^sub_y pixels
/// (over those that exist).
inline cv::Mat1d yuv_plane(const cv::Mat &bgr, int k, int sub_x, int sub_y, const FrameView &v) {
  const int w = (bgr.cols + (1 << sub_x) - 1) >> sub_x, h = (bgr.rows + (1 << sub_y) - 1) >> sub_y;
  cv::Mat1d sum = cv::Mat1d::zeros(h, w), count = cv::Mat1d::zeros(h, w);
  for (int y = 0; y < bgr.rows; ++y)
    for (int x = 0; x < bgr.cols; ++x) {
      const std::uint8_t *p = bgr.ptr(y) + 3 * x;
      const double luma = v.kr * p[2] + (1 - v.kr - v.kb) * p[1] + v.kb * p[0];
      const double value = k == 0   ? 16 + luma * 219 / 255
                           : k == 1 ? 128 + (p[0] - luma) / (2 * (1 - v.kb)) * 224 / 255
                                    : 128 + (p[2] - luma) / (2 * (1 - v.kr)) * 224 / 255;
      sum(y >> sub_y, x >> sub_x) += value;
      count(y >> sub_y, x >> sub_x) += 1;
    }
  return sum / count;
}

/// Packs `bgr` (CV_8UC3) as `layout`, with `padding` bytes of 0xAB after each row and in all unused places. If `deep`,
/// samples of more than 8 bit are rounded to their depth (R, G and B get lower bits without meaning); otherwise they
/// are the 8-bit samples, shifted. gray is Y.
inline Packed pack(const cv::Mat &bgr, Layout layout, int padding = 7, bool deep = false) {
  Packed out;
  FrameView &v = out.view;
  const int w = v.width = bgr.cols, h = v.height = v.rows = bgr.rows;
  using L = Layout;
  const bool full =
      layout == L::y444 || layout == L::y444_10le || layout == L::vuya || layout == L::y410 || is_rgb(layout);
  const bool rows = full || layout == L::nv16 || layout == L::y42b || layout == L::yuy2 || layout == L::uyvy ||
                    layout == L::v210 || layout == L::i422_10le || layout == L::y210;
  const int sub_x = full ? 0 : 1, sub_y = rows ? 0 : 1;
  const int depth = depth_of(layout), scale = 1 << (depth - 8);
  v.model = is_gray(layout) ? ColourModel::gray : is_rgb(layout) ? ColourModel::rgb : ColourModel::yuv;
  const int components = is_gray(layout) ? 1 : 3;
  cv::Mat1i plane[3];
  for (int k = 0; k < components; ++k) {
    if (is_rgb(layout)) {
      plane[k].create(h, w);
      for (int y = 0; y < h; ++y)
        for (int x = 0; x < w; ++x)
          plane[k](y, x) = bgr.ptr(y)[3 * x + 2 - k] * scale + (deep ? (7 * x + 13 * y + k) % scale : 0);
      continue;
    }
    const cv::Mat1d exact = yuv_plane(bgr, k, k ? sub_x : 0, k ? sub_y : 0, v);
    plane[k].create(exact.size());
    for (int y = 0; y < exact.rows; ++y)
      for (int x = 0; x < exact.cols; ++x)
        plane[k](y, x) = static_cast<int>(deep ? std::lround(exact(y, x) * scale) : std::lround(exact(y, x)) * scale);
  }
  // Groups of 10-bit samples, three to a little-endian word, lowest bits first.
  if (layout == L::v210 || layout == L::gray10_le32) {
    const bool v210 = layout == L::v210;
    v.packing = v210 ? Packing::v210 : Packing::gray10;
    const int words = v210 ? (w + 5) / 6 * 4 : (w + 2) / 3, row = words * 4 + padding;
    out.bytes.assign(static_cast<std::size_t>(row) * h - padding, 0);
    v.component[0] = {.data = out.bytes.data(), .row_stride = row};
    for (int y = 0; y < h; ++y)
      for (int i = 0; i < words * 3; ++i) {  // the row's i-th sample; v210 has U0 Y0 V0 Y1 U1 Y2 V1 Y3 …
        const int k = !v210 || i % 2 ? 0 : i % 4 ? 2 : 1, x = !v210 ? i : k ? i / 4 : i / 2;
        const auto s = static_cast<std::uint32_t>(x < plane[k].cols ? plane[k](y, x) : 64) << (i % 3 * 10);
        for (int byte = 0; byte < 4; ++byte)
          out.bytes[static_cast<std::size_t>(y) * row + i / 3 * 4 + byte] |= static_cast<std::uint8_t>(s >> (8 * byte));
      }
    return out;
  }
  // Three 10-bit samples in a 32-bit word for each pixel: the lowest bit of each.
  if (layout == L::y410 || layout == L::r210 || layout == L::bgr10a2_le) {
    const bool big = layout == L::r210;
    constexpr int y410[] = {10, 0, 20}, rgb[] = {20, 10, 0};
    const int *bit = layout == L::y410 ? y410 : rgb, row = 4 * w + padding;
    out.bytes.assign(static_cast<std::size_t>(row) * h - padding, 0xAB);
    for (int k = 0; k < 3; ++k) {
      // The two bytes that hold it, and how far their word has to shift left.
      const int byte = bit[k] / 8;
      v.component[k] = {.data = out.bytes.data() + (big ? 2 - byte : byte),
                        .row_stride = row,
                        .pixel_stride = 4,
                        .bytes = 2,
                        .shift = 8,
                        .left = static_cast<std::uint8_t>(6 - bit[k] % 8),
                        .big_endian = big};
    }
    for (int y = 0; y < h; ++y)
      for (int x = 0; x < w; ++x) {
        std::uint32_t word = 3u << 30;
        for (int k = 0; k < 3; ++k) word |= static_cast<std::uint32_t>(plane[k](y, x)) << bit[k];
        for (int byte = 0; byte < 4; ++byte)
          out.bytes[static_cast<std::size_t>(y) * row + 4 * x + (big ? 3 - byte : byte)] =
              static_cast<std::uint8_t>(word >> (8 * byte));
      }
    return out;
  }
  // Each component's first sample in its plane, its pixel stride in samples, and its plane.
  struct Place {
    int plane, offset, stride;
  } place[3] = {{0, 0, 1}, {1, 0, 1}, {2, 0, 1}};
  const auto places = [&](Place a, Place b, Place c) { place[0] = a, place[1] = b, place[2] = c; };
  const auto pixels = [&](int stride, int a, int b, int c) { places({0, a, stride}, {0, b, stride}, {0, c, stride}); };
  if (layout == L::yv12) places({0, 0, 1}, {2, 0, 1}, {1, 0, 1});
  if (layout == L::nv12 || layout == L::nv16 || layout == L::p010_10le || layout == L::p012_le)
    places({0, 0, 1}, {1, 0, 2}, {1, 1, 2});
  if (layout == L::nv21) places({0, 0, 1}, {1, 1, 2}, {1, 0, 2});
  if (layout == L::yuy2 || layout == L::y210) places({0, 0, 2}, {0, 1, 4}, {0, 3, 4});
  if (layout == L::uyvy) places({0, 1, 2}, {0, 0, 4}, {0, 2, 4});
  if (layout == L::vuya) pixels(4, 2, 1, 0);
  if (layout == L::rgb) pixels(3, 0, 1, 2);
  if (layout == L::bgr) pixels(3, 2, 1, 0);
  if (layout == L::rgbx || layout == L::rgba64_le) pixels(4, 0, 1, 2);
  if (layout == L::bgrx) pixels(4, 2, 1, 0);
  if (layout == L::xrgb || layout == L::argb64_le) pixels(4, 1, 2, 3);
  if (layout == L::xbgr) pixels(4, 3, 2, 1);
  const bool high = layout == L::p010_10le || layout == L::p012_le || layout == L::y210;  // in the word's upper bits
  const int bytes = depth > 8 ? 2 : 1, up = high ? 16 - depth : 0;
  std::ptrdiff_t start[4] = {}, stride[3] = {};
  for (int p = 0; p < 3; ++p) {
    int height = 0;
    std::ptrdiff_t row = 0;
    for (int k = 0; k < components; ++k)
      if (place[k].plane == p) {
        height = plane[k].rows;
        row = std::max<std::ptrdiff_t>(row, plane[k].cols * place[k].stride * bytes);
      }
    stride[p] = height ? row + padding : 0;
    start[p + 1] = start[p] + stride[p] * height;
  }
  out.bytes.assign(static_cast<std::size_t>(start[3] - padding), 0xAB);
  for (int k = 0; k < components; ++k) {
    const Place &at = place[k];
    v.component[k] = {.data = out.bytes.data() + start[at.plane] + at.offset * bytes,
                      .row_stride = stride[at.plane],
                      .pixel_stride = at.stride * bytes,
                      .bytes = static_cast<std::uint8_t>(bytes),
                      .shift = static_cast<std::uint8_t>(depth - 8 + up),
                      .sub_x = static_cast<std::uint8_t>(k ? sub_x : 0),
                      .sub_y = static_cast<std::uint8_t>(k ? sub_y : 0)};
    for (int y = 0; y < plane[k].rows; ++y)
      for (int x = 0; x < plane[k].cols; ++x) {
        std::uint8_t *p =
            out.bytes.data() + start[at.plane] + y * stride[at.plane] + (x * at.stride + at.offset) * bytes;
        const int value = plane[k](y, x) << up;
        p[0] = static_cast<std::uint8_t>(value);
        if (bytes == 2) p[1] = static_cast<std::uint8_t>(value >> 8);
      }
  }
  return out;
}

}  // namespace csd::test
