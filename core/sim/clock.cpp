// SPDX-License-Identifier: LGPL-2.1-or-later
#include "sim/clock.h"

#include <algorithm>
#include <cstdint>
#include <string>

#include "sim/ieee_math.h"

namespace csd::sim {
namespace {

constexpr int glyph_width = 5, glyph_height = 7, advance = 6, margin = 2, letters = 14;

// 5 × 7 dots each, one byte per row, the leftmost dot in bit 4.
constexpr std::uint8_t glyphs[][glyph_height] = {
    {14, 17, 19, 21, 25, 17, 14}, {4, 12, 4, 4, 4, 4, 14},      {14, 17, 1, 2, 4, 8, 31},    {31, 2, 4, 2, 1, 17, 14},
    {2, 6, 10, 18, 31, 2, 2},     {31, 16, 30, 1, 1, 17, 14},   {6, 8, 16, 30, 17, 17, 14},  {31, 1, 2, 4, 8, 8, 8},
    {14, 17, 17, 14, 17, 17, 14}, {14, 17, 17, 15, 1, 2, 12},                                   // 0…9
    {0, 4, 4, 0, 4, 4, 0},        {0, 0, 0, 0, 0, 12, 12},                                      // : .
    {30, 17, 17, 30, 20, 18, 17}, {31, 16, 16, 30, 16, 16, 31}, {14, 17, 16, 16, 16, 17, 14}};  // R E C

int glyph_of(char c) {
  switch (c) {
    case ':':
      return 10;
    case '.':
      return 11;
    case 'R':
      return 12;
    case 'E':
      return 13;
    case 'C':
      return 14;
    default:
      return c >= '0' && c <= '9' ? c - '0' : -1;
  }
}

int dot(cv::Size size) {
  return std::max(1, size.height / 240);
}

}  // namespace

cv::Rect clock_box(cv::Size size) {
  const int d = dot(size);
  const cv::Rect box(8 * d, size.height - (glyph_height + 2 * margin + 4) * d, (letters * advance + 2 * margin) * d,
                     (glyph_height + 2 * margin) * d);
  return box & cv::Rect({}, size);
}

void draw_clock(double time, cv::Mat &picture) {
  const auto hundredths = static_cast<std::int64_t>(floor_of(std::max(time, 0.0) * 100 + 0.5));
  const auto two = [](std::int64_t x) {
    return std::string{static_cast<char>('0' + x / 10 % 10), static_cast<char>('0' + x % 10)};
  };
  const std::int64_t seconds = hundredths / 100;
  const std::string text = "REC " + two(seconds / 3600).substr(1) + ":" + two(seconds / 60 % 60) + ":" +
                           two(seconds % 60) + "." + two(hundredths % 100).substr(0, 1);
  const cv::Rect box = clock_box(picture.size());
  if (box.empty()) return;
  picture(box).setTo(cv::Scalar(0, 0, 0));
  const int d = dot(picture.size());
  for (std::size_t i = 0; i < text.size(); ++i) {
    const int glyph = glyph_of(text[i]);
    if (glyph < 0) continue;
    for (int row = 0; row < glyph_height; ++row) {
      for (int column = 0; column < glyph_width; ++column) {
        if ((glyphs[glyph][row] >> (glyph_width - 1 - column) & 1) == 0) continue;
        const cv::Rect at(box.x + (margin + static_cast<int>(i) * advance + column) * d, box.y + (margin + row) * d, d,
                          d);
        picture(at & box).setTo(cv::Scalar(225, 225, 225));
      }
    }
  }
}

}  // namespace csd::sim
