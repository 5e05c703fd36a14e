// SPDX-License-Identifier: LGPL-2.1-or-later
#include "image/samples.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "core/picture.h"
#include "core/simd_targets.h"

namespace csd {
namespace {

void is_its_scalar_twin(const FrameView &view, const std::string &what) {
  const int components = view.model == ColourModel::gray ? 1 : 3;
  for (int k = 0; k < components; ++k) {
    const int columns = component_columns(view, k), row = component_rows(view, k) - 1;
    for (int first = 0; first < 14; ++first)
      for (int n = 1; first + n <= columns; ++n) {
        std::vector<std::uint8_t> fast(static_cast<std::size_t>(n) + 1, 0xCD), slow(fast);
        read_samples(view, k, row, first, n, fast.data());
        scalar::read_samples(view, k, row, first, n, slow.data());
        ASSERT_EQ(fast, slow) << what << ' ' << k << ' ' << first << ' ' << n;
      }
  }
}

void are_their_scalar_twins() {
  cv::Mat bgr(3, 151, CV_8UC3);
  cv::RNG(5).fill(bgr, cv::RNG::UNIFORM, 0, 256);
  for (const auto layout : test::all_layouts) {
    const auto packed = test::pack(bgr, layout, 7, true);
    is_its_scalar_twin(packed.view, std::to_string(static_cast<int>(layout)));
  }
  auto windowed = test::pack(bgr, test::Layout::gray16_le, 7, true);
  windowed.view.component[0].black = 9001;
  for (const std::uint16_t gain : {257, 1452, 65535}) {
    windowed.view.component[0].gain = gain;
    is_its_scalar_twin(windowed.view, "gain " + std::to_string(gain));
  }
}

TEST(ReadSamples, MatchesItsScalarTwinAtAnyPlaceAndLength) {
  test::on_all_targets(are_their_scalar_twins);
}

TEST(ReadSamples, RoundsDeepSamplesToNearest) {
  cv::Mat bgr(5, 40, CV_8UC3);
  cv::RNG(6).fill(bgr, cv::RNG::UNIFORM, 0, 256);
  for (const auto layout : test::all_layouts) {
    if (test::depth_of(layout) == 8 || test::is_rgb(layout)) continue;
    const int scale = 1 << (test::depth_of(layout) - 8);
    const auto packed = test::pack(bgr, layout, 7, true);
    for (int k = 0; k < (test::is_gray(layout) ? 1 : 3); ++k) {
      const int sub_x = component_columns(packed.view, k) < bgr.cols, sub_y = component_rows(packed.view, k) < bgr.rows;
      const cv::Mat1d exact = test::yuv_plane(bgr, k, sub_x, sub_y, packed.view);
      std::vector<std::uint8_t> out(static_cast<std::size_t>(exact.cols));
      for (int y = 0; y < exact.rows; ++y) {
        read_samples(packed.view, k, y, 0, exact.cols, out.data());
        for (int x = 0; x < exact.cols; ++x) {
          const int deep = static_cast<int>(std::lround(exact(y, x) * scale));
          ASSERT_EQ(out[static_cast<std::size_t>(x)], std::min(255, (deep + scale / 2) / scale))
              << static_cast<int>(layout);
        }
      }
    }
  }
}

/// Other bits in a sample's word, and the order of the word's bytes. By hand: 0x2a7 is 679, which is 169.75 · 4.
TEST(ReadSamples, TakesTenBitsOfAWord) {
  constexpr std::uint32_t sample = 0x2a7, most = 0x3ff;
  for (const std::uint32_t beside : {0u, 0xffffffffu})
    for (const int bit : {0, 10, 20}) {
      const std::uint32_t word = (beside & ~(most << bit)) | sample << bit;
      std::uint8_t little[4], big[4];
      for (int i = 0; i < 4; ++i) little[i] = big[3 - i] = static_cast<std::uint8_t>(word >> (8 * i));
      FrameView view;
      view.width = view.height = view.rows = 1;
      Component &c = view.component[0];
      c = {.pixel_stride = 4, .bytes = 2, .shift = 8, .left = static_cast<std::uint8_t>(6 - bit % 8)};
      std::uint8_t out = 0;
      c.data = little + bit / 8;
      read_samples(view, 0, 0, 0, 1, &out);
      EXPECT_EQ(out, 170) << bit;
      c.data = big + 2 - bit / 8;
      c.big_endian = true;
      read_samples(view, 0, 0, 0, 1, &out);
      EXPECT_EQ(out, 170) << bit;
    }
}

/// A crop that begins within a group.
TEST(ReadSamples, StartsAnywhereInAGroup) {
  cv::Mat bgr(2, 71, CV_8UC3);
  cv::RNG(8).fill(bgr, cv::RNG::UNIFORM, 0, 256);
  for (const auto layout : {test::Layout::v210, test::Layout::gray10_le32}) {
    const auto packed = test::pack(bgr, layout);
    std::vector<std::uint8_t> all(71), part;
    read_samples(packed.view, 0, 1, 0, 71, all.data());
    const int group = layout == test::Layout::v210 ? 6 : 3;
    for (int x = 0; x < 40; ++x) {
      FrameView view = packed.view;
      view.component[0].data += x / group * (layout == test::Layout::v210 ? 16 : 4);
      view.x_offset = x % group;
      view.width = 71 - x;
      part.assign(static_cast<std::size_t>(view.width), 0);
      read_samples(view, 0, 1, 0, view.width, part.data());
      ASSERT_TRUE(std::equal(part.begin(), part.end(), all.begin() + x)) << static_cast<int>(layout) << ' ' << x;
    }
  }
}

}  // namespace
}  // namespace csd
