// SPDX-License-Identifier: LGPL-2.1-or-later
#include "image/frame_rows.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <vector>

#include "core/simd_targets.h"

namespace csd {
namespace {

template <class T>
std::vector<std::vector<T>> noise(int rows, int n, unsigned seed) {
  std::mt19937 random(seed);
  std::vector<std::vector<T>> out(static_cast<std::size_t>(rows), std::vector<T>(static_cast<std::size_t>(n)));
  for (auto &row : out)
    for (auto &v : row) v = static_cast<T>(random());
  return out;
}

template <class T>
std::vector<const T *> pointers(const std::vector<std::vector<T>> &rows) {
  std::vector<const T *> out;
  for (const auto &row : rows) out.push_back(row.data());
  return out;
}

/// Checks what a kernel writes to `count` outputs, and that it leaves the memory behind them alone.
template <class Out, class Scratch, class Kernel>
std::vector<Out> result(Kernel kernel, int n, int count) {
  std::vector<Scratch> scratch(static_cast<std::size_t>(n + row_slack), Scratch{77});
  std::vector<Out> out(static_cast<std::size_t>(count) + 3, Out{99});
  kernel(scratch.data(), out.data());
  return out;
}

constexpr int longest = 150;  // more than two vectors of 64 bytes

void kernels_are_their_scalar_twins() {
  using u8 = std::uint8_t;
  using u16 = std::uint16_t;
  for (int n = 1; n <= longest; ++n) {
    SCOPED_TRACE(n);
    const auto seed = static_cast<unsigned>(n);
    const auto bytes = noise<u8>(5, n, seed);
    const auto words = noise<u16>(5, n, seed + 1000);
    const auto b = pointers(bytes);
    const auto w = pointers(words);
    const auto smooth = [&](auto f) {
      return result<u16, u16>([&](u16 *s, u16 *out) { f(b.data(), n, s, out); }, n, n);
    };
    ASSERT_EQ(smooth(smooth_row), smooth(scalar::smooth_row));
    const auto shrink = [&](auto f) {
      return result<u16, std::uint32_t>([&](std::uint32_t *s, u16 *out) { f(w.data(), n, s, out); }, n, (n + 1) / 2);
    };
    ASSERT_EQ(shrink(shrink_row), shrink(scalar::shrink_row));
    const auto mean = [&](auto f) {
      return result<u8, u16>([&](u16 *s, u8 *out) { f(b.data(), n, s, out); }, n, (n + 1) / 2);
    };
    ASSERT_EQ(mean(mean_row), mean(scalar::mean_row));
    auto forbidden = bytes[1];
    for (auto &v : forbidden) v = v % 2 ? 255 : 0;
    const auto add = [&](auto f) {
      auto sums = words;
      f(b[0], forbidden.data(), n, sums[0].data(), sums[1].data());
      return sums;
    };
    ASSERT_EQ(add(add_row), add(scalar::add_row));
    for (const int part : {0, 1, 30000, 65535}) {
      const auto tissue = [&](auto f) {
        return result<u8, u16>([&](u16 *s, u8 *out) { f(b.data(), w[0], w[1], static_cast<u16>(part), n, s, out); }, n,
                               n);
      };
      ASSERT_EQ(tissue(tissue_row), tissue(scalar::tissue_row));
    }
  }
}

TEST(FrameRows, KernelsMatchTheirScalarTwins) {
  test::on_all_targets(kernels_are_their_scalar_twins);
}

void erosion_is_its_scalar_twin() {
  for (int n = 1; n <= longest; ++n) {
    SCOPED_TRACE(n);
    auto bytes = noise<std::uint8_t>(6, n, static_cast<unsigned>(n));
    for (auto &row : bytes)
      for (auto &v : row) v = v < 20 ? 0 : 255;
    for (auto &v : bytes[5]) v = static_cast<std::uint8_t>(255 - v);
    const auto rows = pointers(bytes);
    const auto erode = [&](auto f) {
      return result<std::uint8_t, std::uint8_t>(
          [&](std::uint8_t *s, std::uint8_t *out) { f(rows.data(), rows[5], n, s, out); }, n, n);
    };
    ASSERT_EQ(erode(erode_row), erode(scalar::erode_row));
  }
}

TEST(FrameRows, ErosionMatchesItsScalarTwin) {
  test::on_all_targets(erosion_is_its_scalar_twin);
}

void largest_values_fit() {
  const std::vector<std::vector<std::uint8_t>> bytes(5, std::vector<std::uint8_t>(longest, 255));
  const std::vector<std::vector<std::uint16_t>> words(5, std::vector<std::uint16_t>(longest, 65535));
  std::vector<std::uint16_t> out(longest), scratch(longest + row_slack);
  std::vector<std::uint32_t> wide(longest + row_slack);
  smooth_row(pointers(bytes).data(), longest, scratch.data(), out.data());
  EXPECT_EQ(out, std::vector<std::uint16_t>(longest, 255 * 256));
  shrink_row(pointers(words).data(), longest, wide.data(), out.data());
  EXPECT_TRUE(std::all_of(out.begin(), out.begin() + longest / 2, [](int v) { return v == 65535; }));
}

TEST(FrameRows, LargestValuesFit) {
  test::on_all_targets(largest_values_fit);
}

/// Limits at the first row (part 0), at the second (65535) and half-way. A value equal to the limit is tissue.
TEST(FrameRows, TissueIsWhatDoesNotExceedTheLimit) {
  const std::vector<std::vector<std::uint8_t>> rows(3, {99, 100, 101, 102});
  const std::vector<std::uint16_t> above(4, 100 * 256 + 1), below(4, 102 * 256 + 1);
  std::vector<std::uint16_t> scratch(4 + row_slack);
  std::vector<std::uint8_t> out(4);
  const auto tissue = [&](std::uint16_t part) {
    tissue_row(pointers(rows).data(), above.data(), below.data(), part, 4, scratch.data(), out.data());
    return out;
  };
  // Smoothed: 99.5, 100, 101, 101.5.
  EXPECT_EQ(tissue(0), (std::vector<std::uint8_t>{255, 255, 0, 0}));
  EXPECT_EQ(tissue(32768), (std::vector<std::uint8_t>{255, 255, 255, 0}));
  EXPECT_EQ(tissue(65535), (std::vector<std::uint8_t>{255, 255, 255, 255}));
}

TEST(FrameRows, MirroredIndices) {
  EXPECT_EQ(mirrored(-2, 5), 2);
  EXPECT_EQ(mirrored(6, 5), 2);
  EXPECT_EQ(mirrored(-2, 2), 0);
  EXPECT_EQ(mirrored(3, 2), 1);
  EXPECT_EQ(mirrored(-2, 1), 0);
}

}  // namespace
}  // namespace csd
