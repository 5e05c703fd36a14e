// SPDX-License-Identifier: LGPL-2.1-or-later
#include "image/pyramid.h"

#include <stdexcept>
#include <vector>

#include "image/frame_rows.h"

namespace csd {

void Pyramid::build(const cv::Mat &luma) {
  if (luma.type() != CV_8UC1 || luma.cols < smallest || luma.rows < smallest)
    throw std::invalid_argument("Pyramid: wants CV_8UC1 of at least " + std::to_string(smallest) + " pixels a side");
  levels_[0].create(luma.size(), CV_16UC1);
  for (std::size_t l = 1; l < levels; ++l)
    levels_[l].create((levels_[l - 1].rows + 1) / 2, (levels_[l - 1].cols + 1) / 2, CV_16UC1);

  const auto slots = static_cast<std::size_t>(luma.cols + row_slack);
  std::vector<std::uint16_t> sums(slots);
  std::vector<std::uint32_t> wide_sums(slots);
  // All levels are computed together, row by row, so that each reads rows that were just written.
  std::array<int, levels> done{};
  for (int y = 0; y < luma.rows; ++y) {
    const std::uint8_t *rows[5];
    for (int k = 0; k < 5; ++k) rows[k] = luma.ptr(mirrored(y + k - 2, luma.rows));
    smooth_row(rows, luma.cols, sums.data(), levels_[0].ptr<std::uint16_t>(y));
    done[0] = y + 1;
    for (std::size_t l = 1; l < levels; ++l) {
      const cv::Mat &fine = levels_[l - 1];
      for (int &j = done[l]; j < levels_[l].rows && done[l - 1] >= std::min(2 * j + 3, fine.rows); ++j) {
        const std::uint16_t *from[5];
        for (int k = 0; k < 5; ++k) from[k] = fine.ptr<std::uint16_t>(mirrored(2 * j + k - 2, fine.rows));
        shrink_row(from, fine.cols, wide_sums.data(), levels_[l].ptr<std::uint16_t>(j));
      }
    }
  }
}

}  // namespace csd
