// SPDX-License-Identifier: LGPL-2.1-or-later
#include <gtest/gtest.h>

#include <algorithm>
#include <opencv2/core.hpp>
#include <vector>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "core/patch/median-inl_test.cpp"
#include <hwy/foreach_target.h>
// After foreach_target.
#include <hwy/highway.h>

#include "patch/median-inl.h"

HWY_BEFORE_NAMESPACE();
namespace csd {
namespace HWY_NAMESPACE {

// `scattered` has kQuantised values.
double MedianOfScattered(const std::int16_t *scattered, int n, int high, int resolution) {
#if HWY_TARGET == HWY_SCALAR
  static_cast<void>(scattered), static_cast<void>(n), static_cast<void>(high), static_cast<void>(resolution);
  return -1;  // this target has none
#else
  return Median(scattered, n, high, resolution);
#endif
}

}  // namespace HWY_NAMESPACE
}  // namespace csd
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
#include "core/simd_targets.h"

namespace csd {
namespace {

HWY_EXPORT(MedianOfScattered);
constexpr std::size_t size = HWY_NAMESPACE::kQuantised;

/// The median of values at random places among ones that don't count.
double median_of(std::vector<std::int16_t> values, cv::RNG &random, int high, int resolution) {
  const int n = static_cast<int>(values.size());
  values.resize(size, 32767);
  for (std::size_t i = size - 1; i > 0; --i)
    std::swap(values[i], values[static_cast<std::size_t>(random.uniform(0, static_cast<int>(i) + 1))]);
  alignas(64) std::int16_t scattered[size];
  std::copy(values.begin(), values.end(), scattered);
  return HWY_DYNAMIC_DISPATCH(MedianOfScattered)(scattered, n, high, resolution);
}

template <class Test>
void on_vector_targets(Test test) {
  test::on_all_targets([&] {
    if (hwy::SupportedTargets() != HWY_SCALAR) test();
  });
}

// The position between the middle value and the next integer depends on how many values are equal to it.
TEST(Median, IsInterpolatedWithinAUnit) {
  on_vector_targets([] {
    cv::RNG random(1);
    EXPECT_DOUBLE_EQ(median_of({7}, random, 32766, 1), 7.5);
    EXPECT_DOUBLE_EQ(median_of({0, 3, 32766}, random, 32766, 1), 3.5);
    EXPECT_DOUBLE_EQ(median_of({0, 5, 5, 5, 9}, random, 32766, 1), 5 + 1.5 / 3);
    EXPECT_DOUBLE_EQ(median_of({2, 2, 4, 4}, random, 32766, 1), 4.25);
    EXPECT_DOUBLE_EQ(median_of({0, 0, 0}, random, 0, 1), .5);
  });
}

TEST(Median, IsWithinItsResolutionOfTheMiddleValue) {
  on_vector_targets([] {
    cv::RNG random(2);
    for (int k = 0; k < 300; ++k) {
      const int n = random.uniform(1, static_cast<int>(size) + 1), largest = 1 << random.uniform(1, 15);
      std::vector<std::int16_t> values(static_cast<std::size_t>(n));
      for (auto &v : values) v = static_cast<std::int16_t>(random.uniform(0, largest));
      auto sorted = values;
      std::sort(sorted.begin(), sorted.end());
      const double middle = sorted[static_cast<std::size_t>(n / 2)];
      for (const int resolution : {1, 8, 32}) {
        EXPECT_NEAR(median_of(values, random, 32766, resolution), middle, resolution);
        EXPECT_NEAR(median_of(values, random, static_cast<int>(middle), resolution), middle, resolution);
      }
    }
  });
}

}  // namespace
}  // namespace csd
#endif  // HWY_ONCE
