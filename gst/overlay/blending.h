// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <opencv2/core.hpp>
#include <vector>

namespace csd {

/// A sprite in the picture's colour model: alpha, and per component 16 times the 8-bit code value times alpha/255, row
/// by row. A linear map of a premultiplied colour stays premultiplied.
struct NativeSprite {
  int width = 0, height = 0;
  cv::Point origin;
  std::vector<cv::Range> covered;
  std::vector<std::uint8_t> alpha;
  std::array<std::vector<std::uint16_t>, 4> value;

  std::size_t bytes() const {
    return alpha.size() * (1 + value.size() * sizeof(std::uint16_t)) + covered.size() * sizeof covered[0];
  }
};

constexpr int fraction = 16;

/// The grid of a component of the frame, and its samples' range.
struct Grid {
  int sub_x = 0, sub_y = 0;
  unsigned largest = 255;  ///< maximum of a sample
  unsigned one = 255;      ///< 8-bit 255 in the sample's depth
  bool fields = false;     ///< chroma lines alternate between the fields

  /// The component line for frame line `y`.
  int line_of(int y) const {
    if (sub_y == 0) return y;
    return fields ? (y >> (1 + sub_y)) * 2 + (y & 1) : y >> sub_y;
  }
  /// The `n`-th frame line that component line `line` covers.
  int frame_line(int line, int n) const {
    if (sub_y == 0) return line;
    return fields ? ((line >> 1) << (1 + sub_y)) + (line & 1) + 2 * n : (line << sub_y) + n;
  }
};

/// Where a sprite lies and its drawable part, in pixels of the frame.
struct Placement {
  int x, y;
  cv::Rect clip;
};

/// Blends component line `line`. Instantiated for each subsampling, so divisors are constants.
template <int sub_x, int sub_y, class Row>
void blend_line(const Row &row, const Grid &grid, const NativeSprite &sprite, std::size_t component, int line,
                const Placement &at) {
  constexpr int across = 1 << sub_x, down = 1 << sub_y;
  constexpr unsigned whole = 255u * across * down;
  int begin = at.clip.x + at.clip.width, end = at.clip.x;
  std::array<const std::uint8_t *, down> alpha{};
  std::array<const std::uint16_t *, down> value{};
  for (int n = 0; n < down; ++n) {
    const int y = grid.frame_line(line, n);
    if (y < at.clip.y || y >= at.clip.y + at.clip.height) continue;
    const cv::Range covered = sprite.covered[static_cast<std::size_t>(y - at.y)];
    if (covered.empty()) continue;
    begin = std::min(begin, std::max(at.clip.x, at.x + covered.start));
    end = std::max(end, std::min(at.clip.x + at.clip.width, at.x + covered.end));
    alpha[static_cast<std::size_t>(n)] = sprite.alpha.data() + (y - at.y) * sprite.width;
    value[static_cast<std::size_t>(n)] = sprite.value[component].data() + (y - at.y) * sprite.width;
  }
  if (begin >= end) return;
  const unsigned largest = grid.largest, one = grid.one;  // local, because written bytes might alias the grid
  for (int column = begin >> sub_x; column <= (end - 1) >> sub_x; ++column) {
    unsigned a = 0, v = 0;
    for (std::size_t n = 0; n < down; ++n) {
      if (!alpha[n]) continue;
      for (int i = 0; i < across; ++i) {
        const int x = column * across + i;
        if (x < begin || x >= end) continue;
        a += alpha[n][x - at.x];
        v += value[n][x - at.x];
      }
    }
    if (a == 0) continue;
    // old·(1 − a) + v, rounded, with v's 16ths and the pixels per sample divided out.
    const unsigned old = row.get(column) * (whole - a) * fraction;
    const unsigned sum = old + v * one;
    row.set(column, std::min((sum + whole * fraction / 2) / (whole * fraction), largest));
  }
}

/// The same for each subsampling.
template <class Row>
void blend_line(const Row &row, const Grid &grid, const NativeSprite &sprite, std::size_t component, int line,
                const Placement &at) {
  if (grid.sub_x == 0)
    blend_line<0, 0>(row, grid, sprite, component, line, at);
  else if (grid.sub_x == 1 && grid.sub_y == 0)
    blend_line<1, 0>(row, grid, sprite, component, line, at);
  else if (grid.sub_x == 1)
    blend_line<1, 1>(row, grid, sprite, component, line, at);
  else if (grid.sub_y == 0)
    blend_line<2, 0>(row, grid, sprite, component, line, at);
  else
    blend_line<2, 2>(row, grid, sprite, component, line, at);
}

}  // namespace csd
