// SPDX-License-Identifier: LGPL-2.1-or-later
#include "image/samples.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "core/picture.h"
#include "core/simd_targets.h"

namespace csd {
namespace {

void is_its_scalar_twin() {
  cv::Mat bgr(3, 151, CV_8UC3);
  cv::RNG(5).fill(bgr, cv::RNG::UNIFORM, 0, 256);
  for (const auto layout : test::all_layouts) {
    const auto packed = test::pack(bgr, layout, 7, true);
    const int components = packed.view.model == ColourModel::gray ? 1 : 3;
    for (int k = 0; k < components; ++k) {
      const int columns = component_columns(packed.view, k), row = component_rows(packed.view, k) - 1;
      for (int first = 0; first < 14; ++first)
        for (int n = 1; first + n <= columns; ++n) {
          std::vector<std::uint8_t> fast(static_cast<std::size_t>(n) + 1, 0xCD), slow(fast);
          read_samples(packed.view, k, row, first, n, fast.data());
          scalar::read_samples(packed.view, k, row, first, n, slow.data());
          ASSERT_EQ(fast, slow) << static_cast<int>(layout) << ' ' << k << ' ' << first << ' ' << n;
        }
    }
  }
}

TEST(ReadSamples, IsItsScalarTwinAtAnyPlaceAndLength) {
  test::on_all_targets(is_its_scalar_twin);
}

TEST(ReadSamples, DeepSamplesAreRoundedToNearest) {
  cv::Mat bgr(5, 40, CV_8UC3);
  cv::RNG(6).fill(bgr, cv::RNG::UNIFORM, 0, 256);
  using L = test::Layout;
  for (const auto layout : {L::v210, L::i422_10le, L::i420_10le, L::p010_10le, L::y444_10le}) {
    const auto packed = test::pack(bgr, layout, 7, true);
    for (int k = 0; k < 3; ++k) {
      const int sub_x = k && layout != L::y444_10le;
      const int sub_y = k && (layout == L::i420_10le || layout == L::p010_10le);
      const cv::Mat1d exact = test::yuv_plane(bgr, k, sub_x, sub_y, packed.view);
      std::vector<std::uint8_t> out(static_cast<std::size_t>(exact.cols));
      for (int y = 0; y < exact.rows; ++y) {
        read_samples(packed.view, k, y, 0, exact.cols, out.data());
        for (int x = 0; x < exact.cols; ++x) {
          const int ten = static_cast<int>(std::lround(exact(y, x) * 4));
          ASSERT_EQ(out[static_cast<std::size_t>(x)], std::min(255, (ten + 2) / 4));
        }
      }
    }
  }
}

}  // namespace
}  // namespace csd
