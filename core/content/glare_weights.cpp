// SPDX-License-Identifier: LGPL-2.1-or-later
#include "content/glare_weights.h"

#include <opencv2/imgproc.hpp>

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <vector>

#include "image/frame_rows.h"
#include "image/work_frame.h"

namespace csd {
namespace {

constexpr int clipped = 250;  // grey levels, with noise and compression

using Words = std::vector<std::uint16_t>;
using Bytes = std::vector<std::uint8_t>;

/// A cell without a value takes that of the next one in its row; a row without values takes the next row's.
void fill_unknown(cv::Mat1b &cells, const cv::Mat1b &known) {
  std::vector<int> rows;
  for (int j = 0; j < cells.rows; ++j) {
    int last = -1;
    for (int i = 0; i < cells.cols; ++i) {
      if (!known(j, i)) continue;
      for (int k = last + 1; k < i; ++k) cells(j, k) = last < 0 || i - k < k - last ? cells(j, i) : cells(j, last);
      last = i;
    }
    if (last < 0) continue;
    for (int k = last + 1; k < cells.cols; ++k) cells(j, k) = cells(j, last);
    rows.push_back(j);
  }
  if (rows.empty()) return;
  for (int j = 0, at = 0; j < cells.rows; ++j) {
    const auto row = [&](int k) { return rows[static_cast<std::size_t>(k)]; };
    while (at + 1 < static_cast<int>(rows.size()) && std::abs(row(at + 1) - j) < std::abs(row(at) - j)) ++at;
    if (row(at) != j) cells.row(row(at)).copyTo(cells.row(j));
  }
}

/// Means over cells of the allowed pixels; a cell needs enough of them.
cv::Mat1b means_of_cells(const cv::Mat &least_channel, const cv::Mat &forbidden, int cell) {
  const int n = least_channel.cols, columns = (n + cell - 1) / cell, rows = (least_channel.rows + cell - 1) / cell;
  cv::Mat1b mean(rows, columns, std::uint8_t{0}), known(rows, columns);
  Words sums(static_cast<std::size_t>(n)), counts(sums.size());
  const Bytes none(sums.size(), 0);
  for (int j = 0; j < rows; ++j) {
    std::fill(sums.begin(), sums.end(), std::uint16_t{0});
    std::fill(counts.begin(), counts.end(), std::uint16_t{0});
    for (int y = j * cell; y < std::min((j + 1) * cell, least_channel.rows); ++y)
      add_row(least_channel.ptr(y), forbidden.empty() ? none.data() : forbidden.ptr(y), n, sums.data(), counts.data());
    for (int i = 0; i < columns; ++i) {
      unsigned sum = 0, count = 0;
      for (int x = i * cell; x < std::min((i + 1) * cell, n); ++x) {
        sum += sums[static_cast<std::size_t>(x)];
        count += counts[static_cast<std::size_t>(x)];
      }
      known(j, i) = count >= static_cast<unsigned>(cell);
      if (known(j, i)) mean(j, i) = static_cast<std::uint8_t>((sum + count / 2) / count);
    }
  }
  fill_unknown(mean, known);
  return mean;
}

/// Brightness above which a pixel is a highlight, 1/256.
int limit(int surroundings, double share) {
  return static_cast<int>(
      std::lround(std::clamp(256 * (surroundings + share * (clipped - surroundings)), 0.0, 65535.0)));
}

/// Limits of a row of cells at every pixel, interpolated linearly between the cells' centres.
void limits_of_row(const cv::Mat1b &cells, int row, int cell, double share, Words &out) {
  const int n = static_cast<int>(out.size());
  for (int i = -1, begin = 0; begin < n; ++i) {
    const int end = std::min((i + 1) * cell + cell / 2, n);
    const int left = limit(cells(row, std::max(i, 0)), share);
    const int right = limit(cells(row, std::min(i + 1, cells.cols - 1)), share);
    const int step = (right - left) * 256 / cell;
    const int start = left * 256 + (cell % 2 ? 0 : step / 2) + 128;
    for (int x = begin; x < end; ++x)
      out[static_cast<std::size_t>(x)] = static_cast<std::uint16_t>((start + step * (x - begin)) >> 8);
    begin = end;
  }
}

}  // namespace

void GlareWeights::build(const WorkFrame &frame, const cv::Mat &forbidden, double highlight) {
  const cv::Size size = frame.size();
  if (!forbidden.empty() && (forbidden.type() != CV_8UC1 || forbidden.size() != size))
    throw std::invalid_argument("GlareWeights: forbidden must be CV_8UC1 of the working size");
  constexpr int reach = 2, side = 2 * reach + 1;  // of erode_row
  const int cell = std::max(1, static_cast<int>(std::lround(16 * size.height / 480.)));
  levels_[0].create(size, CV_8UC1);
  for (std::size_t l = 1; l < Pyramid::levels; ++l)
    levels_[l].create((levels_[l - 1].rows + 1) / 2, (levels_[l - 1].cols + 1) / 2, CV_8UC1);

  frame.gather_least(least_);
  cv::Mat1b surroundings;
  cv::medianBlur(means_of_cells(least_, forbidden, cell), surroundings, 5);

  const auto n = static_cast<std::size_t>(size.width), slots = n + row_slack;
  Words above(n), below(n), sums(slots);
  Bytes bytes(slots), all(n, 255), none(n, 0), hidden(n);
  // Rows of tissue before the erosion, in a ring buffer as high as its window: row y is at y modulo that height.
  std::vector<Bytes> tissue(side, Bytes(n));
  const auto tissue_at = [&](int y) {
    return y < 0 || y >= size.height ? all.data() : tissue[static_cast<std::size_t>(y % side)].data();
  };
  const auto mark = [&](int y) {
    // Position between the centres of cells, in half pixels.
    const int at = 2 * y + 1 + cell, row = at / (2 * cell) - 1, part = at % (2 * cell);
    if (y == 0 || part < 2) {
      limits_of_row(surroundings, std::max(row, 0), cell, highlight, above);
      limits_of_row(surroundings, std::min(row + 1, surroundings.rows - 1), cell, highlight, below);
    }
    const std::uint8_t *rows[3];
    for (int k = 0; k < 3; ++k) rows[k] = least_.ptr(mirrored(y + k - 1, size.height));
    tissue_row(rows, above.data(), below.data(), static_cast<std::uint16_t>(part * 65536 / (2 * cell)), size.width,
               sums.data(), tissue[static_cast<std::size_t>(y % side)].data());
  };

  // All levels are computed together, row by row, so that each reads rows that were just written.
  std::array<int, Pyramid::levels> done{};
  for (int y = 0; y < reach && y < size.height; ++y) mark(y);
  for (int y = 0; y < size.height; ++y) {
    if (y + reach < size.height) mark(y + reach);
    const std::uint8_t *around[side];
    for (int k = 0; k < side; ++k) around[k] = tissue_at(y + k - reach);
    const std::uint8_t *outside = forbidden.empty() ? none.data() : forbidden.ptr(y), *least_channel = least_.ptr(y);
    for (std::size_t x = 0; x < n; ++x) hidden[x] = least_channel[x] >= clipped ? 255 : outside[x];
    erode_row(around, hidden.data(), size.width, bytes.data(), levels_[0].ptr(y));
    done[0] = y + 1;
    for (std::size_t l = 1; l < Pyramid::levels; ++l) {
      const cv::Mat &fine = levels_[l - 1];
      for (int &j = done[l]; j < levels_[l].rows && done[l - 1] >= std::min(2 * j + 2, fine.rows); ++j) {
        const std::uint8_t *rows[3];
        for (int k = 0; k < 3; ++k) rows[k] = fine.ptr(mirrored(2 * j + k - 1, fine.rows));
        mean_row(rows, fine.cols, sums.data(), levels_[l].ptr(j));
      }
    }
  }
}

}  // namespace csd
