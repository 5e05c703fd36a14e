// SPDX-License-Identifier: LGPL-2.1-or-later
#include "image/gray_window.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstddef>
#include <functional>
#include <numeric>

namespace csd {
namespace {

constexpr int max_samples = 16384;   // the 0.5 % at an end are 80 of them; its limit varies by 0.1 of the noise's σ
constexpr int beyond = 200;          // one in this many pixels is below the range, and one above
constexpr double margin = 1.0 / 12;  // of the range, on either side: more than `out_of_place`
constexpr double out_of_place = 1.0 / 16, in_place = 1.0 / 64;  // of the window
constexpr double follow_in = 0.3;                               // s
constexpr double too_little = 1.0 / 4;                          // of the window
constexpr int levels = 256;
constexpr double brightest = 65535;

}  // namespace

FrameView GrayWindow::look(const FrameView &view, std::int64_t time) {
  if (!view.open_range || !view.has_pixels()) return view;
  if (view.width != width_ || view.rows != rows_) reset();
  width_ = view.width;
  rows_ = view.rows;
  follow(measure(view), time);
  time_ = time;
  FrameView out = view;
  Component &c = out.component[0];
  c.black = static_cast<std::uint16_t>(std::lround(black_));
  c.gain = static_cast<std::uint16_t>(std::min(levels * 65536 / (white_ - black_), brightest));
  return out;
}

GrayWindow::Seen GrayWindow::measure(const FrameView &view) {
  coarse_.resize(256);
  fine_.resize(65536);
  const Component &c = view.component[0];
  int every = 1;
  const auto samples = [&](int n) { return (n + every - 1) / every; };
  while (std::int64_t{samples(view.width)} * samples(view.rows) > max_samples) ++every;
  unsigned all = 256;
  int count = 0;
  for (int y = std::min(every, view.rows) / 2; y < view.rows; y += every)
    for (int x = std::min(every, view.width) / 2; x < view.width; x += every, ++count) {
      const std::uint8_t *p = c.data + y * c.row_stride + x * c.pixel_stride;
      const std::uint8_t low = p[c.big_endian], high = p[!c.big_endian];
      ++fine_[static_cast<std::size_t>(low | high << 8)];
      ++coarse_[high];
      all |= low;
    }
  const int step = 1 << std::countr_zero(all);
  known_ &= step >= step_;
  step_ = std::min(step_, step);
  const int masked = fine_[0] < count ? fine_[0] : 0;
  count -= masked;
  const auto level = [&](int rank) {
    rank += masked;
    std::size_t i = 0;
    for (; rank >= coarse_[i]; ++i) rank -= coarse_[i];
    std::size_t v = i * 256;
    for (; rank >= fine_[v]; ++v) rank -= fine_[v];
    return static_cast<double>(v);
  };
  const Seen seen{{level(count / beyond), level(count - 1 - count / beyond)}, level(count / 2)};
  for (std::size_t i = 0; i < coarse_.size(); ++i)
    if (coarse_[i] > 0) std::fill_n(fine_.begin() + static_cast<std::ptrdiff_t>(256 * i), 256, std::uint16_t{0});
  std::fill(coarse_.begin(), coarse_.end(), std::uint16_t{0});
  return seen;
}

GrayWindow::Range GrayWindow::lasting(const Range &seen, std::int64_t time) {
  constexpr std::int64_t tenth = 100'000'000;
  constexpr std::int64_t tenths = std::tuple_size_v<decltype(recent_)>;
  const std::int64_t now = time / tenth;
  for (std::int64_t i = std::max(time_ / tenth, now - tenths) + 1; i <= now; ++i)
    recent_[static_cast<std::size_t>(i % tenths)] = {};
  Range &latest = recent_[static_cast<std::size_t>(now % tenths)];
  latest = latest & seen;
  return std::accumulate(recent_.begin(), recent_.end(), Range{}, std::bit_and());
}

void GrayWindow::follow(const Seen &seen, std::int64_t time) {
  const double width = white_ - black_;
  const double least_range = levels * step_;
  const bool shows_little = seen.median < black_ || seen.median > white_ ||
                            std::max(seen.range.high - seen.range.low, least_range) < too_little * width;
  if (!known_ || shows_little) {
    known_ = true;
    moving_ = false;
    recent_.fill({});
    range_ = lasting(seen.range, time);
    return fit();
  }
  const Range range = lasting(seen.range, time);
  const double off = std::max(std::abs(range.low - range_.low), std::abs(range.high - range_.high));
  moving_ = off > (moving_ ? in_place : out_of_place) * width && range.low < range.high;
  if (!moving_) return;
  // Limits the distance of an end to a window's width, because the range may grow from a small part of 16 bit to all of
  // it.
  const double part = 1 - std::exp(static_cast<double>(time_ - time) / 1e9 / follow_in);
  range_.low += part * std::clamp(range.low - range_.low, -width, width);
  range_.high += part * std::clamp(range.high - range_.high, -width, width);
  fit();
}

void GrayWindow::fit() {
  const double around = margin * (range_.high - range_.low), least_range = levels * step_;
  black_ = std::max(range_.low - around, 0.0);
  white_ = std::min(range_.high + around, brightest + 1);
  if (white_ - black_ >= least_range) return;
  black_ = std::min(black_, brightest + 1 - least_range);
  white_ = black_ + least_range;
}

}  // namespace csd
