// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "csd2012/learn/sample_set.h"

namespace csd {

/// The samples of one node in the layout for learning: [pixel][sample], those labelled feature first.
///
/// A row holds one pixel of all samples. In it each class is a contiguous run of bytes that starts at a multiple of 64
/// bytes and is zero-padded to one, so a kernel compares two rows without a tail. The padding counts as "equal" and is
/// subtracted.
class NodeSamples {
 public:
  static constexpr std::size_t align = 64;

  /// Gathers the samples `features` and `others` of `set`. Reuses its memory.
  void gather(const SampleSet &set, std::span<const SampleId> features, std::span<const SampleId> others);

  std::size_t pixels() const { return pixels_; }
  std::size_t features() const { return features_; }
  std::size_t others() const { return others_; }
  std::size_t size() const { return features_ + others_; }

  /// The features() values of a pixel, aligned to 64 bytes, readable up to feature_bytes().
  const std::uint8_t *feature_row(std::size_t pixel) const { return data_ + pixel * stride_; }
  /// The others() values of a pixel, likewise.
  const std::uint8_t *other_row(std::size_t pixel) const { return data_ + pixel * stride_ + feature_bytes(); }
  std::size_t feature_bytes() const { return (features_ + align - 1) / align * align; }
  std::size_t other_bytes() const { return (others_ + align - 1) / align * align; }

 private:
  std::vector<std::uint8_t> storage_;
  std::uint8_t *data_ = nullptr;  ///< the first multiple of 64 bytes in storage_
  std::size_t stride_ = 0, pixels_ = 0, features_ = 0, others_ = 0;
};

/// Transposes `count` ≤ 16 rows of bytes (read up to `row_bytes`, a multiple of 16): out[p·stride + i] is rows[i][p]
/// for p < row_bytes, and 0 for count ≤ i < 16. `out` must be aligned to 16 bytes.
void transpose16(const std::uint8_t *const *rows, std::size_t count, std::size_t row_bytes, std::uint8_t *out,
                 std::size_t stride);
/// The same without SIMD.
void transpose16_scalar(const std::uint8_t *const *rows, std::size_t count, std::size_t row_bytes, std::uint8_t *out,
                        std::size_t stride);

}  // namespace csd
