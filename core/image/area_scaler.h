// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <opencv2/core.hpp>

#include <cstdint>
#include <functional>
#include <vector>

namespace csd {

/// One axis of an area average: the samples that each output pixel covers, and their weights.
///
/// A sample counts as constant over the picture pixels that it stands for, so a subsampled component gives the same
/// result as at full resolution.
class AreaAxis {
 public:
  AreaAxis() = default;
  /// Scales `pixels` of the picture to `outputs`, both ≥ 1. A sample stands for 2^`sub` pixels, the last one for the
  /// remainder.
  AreaAxis(int pixels, int sub, int outputs);

  int outputs() const { return static_cast<int>(begin_.size()); }
  int begin(int i) const { return begin_[static_cast<std::size_t>(i)]; }  ///< first sample that output i covers
  int end(int i) const { return begin(i) + taps(i); }                     ///< one past the last
  int taps(int i) const { return offset_[static_cast<std::size_t>(i) + 1] - offset_[static_cast<std::size_t>(i)]; }
  /// taps(i) weights, 1/65536. They sum to 65535, so that each fits 16 bit.
  const std::uint16_t *weights(int i) const { return weights_.data() + offset_[static_cast<std::size_t>(i)]; }

 private:
  std::vector<int> begin_, offset_;
  std::vector<std::uint16_t> weights_;
};

/// Returns `n` samples from column `first` of row `row`, either in place or copied to `buffer`, which holds n.
using RowReader = std::function<const std::uint8_t *(int row, int first, int n, std::uint8_t *buffer)>;

/// Computes rows `range` of the area average of `read`'s samples into `out`: CV_8UC1, columns.outputs() ×
/// rows.outputs(), allocated.
///
/// Differs from the exact average by less than 0.75 for factors up to 16; constant input is reproduced exactly. No
/// output depends on `range`. Each sample is read about once.
void scale_area(const AreaAxis &columns, const AreaAxis &rows, const RowReader &read, cv::Range range, cv::Mat &out);

/// The two kernels, dispatched to the machine's best SIMD target at run time, and in `scalar` without SIMD, with
/// bit-identical results.
///
/// out[i] = bias + Σ over t < taps of floor(rows[t][i] · weights[t] / 256): 8.8 fixed point.
void blend_rows(const std::uint8_t *const *rows, const std::uint16_t *weights, int taps, int n, std::uint16_t *out);
/// Converts eight rows of 8.8 fixed point, `stride` apart, to outputs `first` … first + n of `axis`, 8 bit, in eight
/// rows at `out`. Column 0 of `in` is sample axis.begin(first). `columns` of each row must be readable, and eight times
/// as many writable at `scratch`. `n` and `columns` are multiples of 8.
void blend_columns(const AreaAxis &axis, int first, int n, const std::uint16_t *in, int stride, int columns,
                   std::uint16_t *scratch, std::uint8_t *out, int out_stride);
namespace scalar {
void blend_rows(const std::uint8_t *const *rows, const std::uint16_t *weights, int taps, int n, std::uint16_t *out);
void blend_columns(const AreaAxis &axis, int first, int n, const std::uint16_t *in, int stride, int columns,
                   std::uint16_t *scratch, std::uint8_t *out, int out_stride);
}  // namespace scalar

}  // namespace csd
