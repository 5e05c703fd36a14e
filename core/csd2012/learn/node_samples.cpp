// SPDX-License-Identifier: LGPL-2.1-or-later
#include "csd2012/learn/node_samples.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "csd2012/learn/node_samples.cpp"
#include <hwy/foreach_target.h>
// After foreach_target.
#include <hwy/highway.h>

#include <algorithm>
#include <array>

HWY_BEFORE_NAMESPACE();
namespace csd::HWY_NAMESPACE {

#if HWY_TARGET == HWY_SCALAR  // below SSSE3: without SIMD

void Transpose16(const std::uint8_t *const *rows, std::size_t count, std::size_t row_bytes, std::uint8_t *out,
                 std::size_t stride) {
  transpose16_scalar(rows, count, row_bytes, out, stride);
}

#else

namespace hn = hwy::HWY_NAMESPACE;

// 16×16 bytes at a time, by four rounds of interleaving; each doubles the run length.
void Transpose16(const std::uint8_t *const *rows, std::size_t count, std::size_t row_bytes,
                 std::uint8_t *HWY_RESTRICT out, std::size_t stride) {
  const hn::FixedTag<std::uint8_t, 16> d;
  using V = hn::Vec<decltype(d)>;
  for (std::size_t p = 0; p < row_bytes; p += 16) {
    V v[16], w[16];
    for (std::size_t i = 0; i < 16; ++i) v[i] = i < count ? hn::LoadU(d, rows[i] + p) : hn::Zero(d);
    // Four perfect shuffles of the rows: row i meets row i + 8.
    for (int round = 0; round < 4; ++round) {
      for (std::size_t i = 0; i < 8; ++i) {
        w[2 * i] = hn::InterleaveLower(d, v[i], v[i + 8]);
        w[2 * i + 1] = hn::InterleaveUpper(d, v[i], v[i + 8]);
      }
      for (std::size_t i = 0; i < 16; ++i) v[i] = w[i];
    }
    for (std::size_t i = 0; i < 16; ++i) hn::Store(v[i], d, out + (p + i) * stride);
  }
}

#endif

}  // namespace csd::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace csd {

HWY_EXPORT(Transpose16);

void NodeSamples::gather(const SampleSet &set, std::span<const SampleId> features, std::span<const SampleId> others) {
  pixels_ = static_cast<std::size_t>(set.pixels());
  features_ = features.size();
  others_ = others.size();
  stride_ = feature_bytes() + other_bytes();
  // Rows at multiples of 512 bytes would share few cache sets when 16 columns are written down all rows.
  if (stride_ % 512 == 0) stride_ += align;
  // row_bytes() ≥ pixels_ rows are written; those beyond pixels_ hold zeros.
  const std::size_t wanted = set.row_bytes() * stride_ + align;
  if (storage_.size() < wanted) storage_.resize(wanted);
  const auto address = reinterpret_cast<std::uintptr_t>(storage_.data());
  data_ = storage_.data() + (align - address % align) % align;

  constexpr std::size_t block = 16;
  std::array<const std::uint8_t *, block> rows{};
  const auto turn = [&](std::span<const SampleId> ids, std::size_t column, std::size_t bytes) {
    for (std::size_t i = 0; i < bytes; i += block) {
      const std::size_t count = i < ids.size() ? std::min(block, ids.size() - i) : 0;
      for (std::size_t k = 0; k < count; ++k) rows[k] = set.patch(ids[i + k]);
      transpose16(rows.data(), count, set.row_bytes(), data_ + column + i, stride_);
    }
  };
  turn(features, 0, feature_bytes());
  turn(others, feature_bytes(), other_bytes());
}

void transpose16(const std::uint8_t *const *rows, std::size_t count, std::size_t row_bytes, std::uint8_t *out,
                 std::size_t stride) {
  HWY_DYNAMIC_DISPATCH(Transpose16)(rows, count, row_bytes, out, stride);
}

void transpose16_scalar(const std::uint8_t *const *rows, std::size_t count, std::size_t row_bytes, std::uint8_t *out,
                        std::size_t stride) {
  for (std::size_t p = 0; p < row_bytes; ++p) {
    std::uint8_t *column = out + p * stride;
    for (std::size_t i = 0; i < 16; ++i) column[i] = i < count ? rows[i][p] : 0;
  }
}

}  // namespace csd
#endif
