// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <opencv2/core.hpp>

#include <cstdint>
#include <functional>
#include <vector>

namespace csd {

/// One axis of an area average: which samples each output pixel covers, and by how much of itself.
///
/// Samples are taken as constant over the picture pixels that they stand for, so a subsampled component gives what the
/// same component at full resolution would.
class AreaAxis {
 public:
  AreaAxis() = default;
  /// `pixels` of the picture become `outputs`, both ≥ 1; a sample stands for 2^`sub` of them, the last one for what is
  /// left.
  AreaAxis(int pixels, int sub, int outputs);

  int outputs() const { return static_cast<int>(begin_.size()); }
  int begin(int i) const { return begin_[static_cast<std::size_t>(i)]; }  ///< first sample that output i covers
  int end(int i) const { return begin(i) + taps(i); }                     ///< one past the last
  int taps(int i) const { return offset_[static_cast<std::size_t>(i) + 1] - offset_[static_cast<std::size_t>(i)]; }
  /// taps(i) weights, 1/65536; they add up to 65535, so that each of them fits.
  const std::uint16_t *weights(int i) const { return weights_.data() + offset_[static_cast<std::size_t>(i)]; }

 private:
  std::vector<int> begin_, offset_;
  std::vector<std::uint16_t> weights_;
};

/// Gives `n` samples from column `first` of row `row`, either where they are or in `buffer`, which holds n.
using RowReader = std::function<const std::uint8_t *(int row, int first, int n, std::uint8_t *buffer)>;

/// Rows `range` of the area average of what `read` gives: CV_8UC1 `out`, columns.outputs() × rows.outputs(), exists.
///
/// Differs from the exact average by less than 0.75 for factors up to 16; what is constant stays as it is. No output
/// depends on `range`. Each sample is read about once.
void scale_area(const AreaAxis &columns, const AreaAxis &rows, const RowReader &read, cv::Range range, cv::Mat &out);

/// The two kernels, dispatched to the best SIMD target of the machine at run time, and in `scalar` without SIMD: bit
/// for bit the same.
///
/// out[i] = bias + Σ over t < taps of floor(rows[t][i] · weights[t] / 256): 8.8 fixed point.
void blend_rows(const std::uint8_t *const *rows, const std::uint16_t *weights, int taps, int n, std::uint16_t *out);
/// Eight rows of 8.8 fixed point, `stride` apart, to outputs `first` … first + n of `axis`, 8 bit, in eight rows at
/// `out`. Column 0 of `in` is sample axis.begin(first); `columns` of each row can be read, and as many as that times
/// eight be written to `scratch`. `n` and `columns` are multiples of 8.
void blend_columns(const AreaAxis &axis, int first, int n, const std::uint16_t *in, int stride, int columns,
                   std::uint16_t *scratch, std::uint8_t *out, int out_stride);
namespace scalar {
void blend_rows(const std::uint8_t *const *rows, const std::uint16_t *weights, int taps, int n, std::uint16_t *out);
void blend_columns(const AreaAxis &axis, int first, int n, const std::uint16_t *in, int stride, int columns,
                   std::uint16_t *scratch, std::uint8_t *out, int out_stride);
}  // namespace scalar

}  // namespace csd
