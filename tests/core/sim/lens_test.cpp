// SPDX-License-Identifier: LGPL-2.1-or-later
#include "sim/lens.h"

#include <gtest/gtest.h>

#include <algorithm>

namespace csd::sim {
namespace {

const cv::Size size{160, 120};

Effects only(const std::string &text) {
  Effects e;
  e.set(text);
  return e;
}

/// The remaining contrast of a fine grating seen through the lens.
double contrast(const Lens &lens) {
  Canvas c;
  c.resize(size);
  for (std::size_t k = 0; k < 3; ++k)
    for (int y = 0; y < size.height; ++y)
      for (int x = 0; x < size.width; ++x) c.row(k, y)[x] = x / 4 % 2 != 0 ? 150.0F : 50.0F;
  std::vector<float> scratch;
  lens.draw(c, scratch);
  const auto [low, high] = std::minmax_element(c.row(1, 60) + 60, c.row(1, 60) + 100);
  return (*high - *low) / 100;
}

TEST(Lens, IsClearWithoutEffects) {
  EXPECT_EQ(contrast(Lens(6, Effects(), size)), 1);
  EXPECT_EQ(Lens(6, Effects(), size).lost({80, 60}), 0);
}

TEST(Lens, GoesOutOfFocusAndBack) {
  EXPECT_GT(contrast(Lens(1, only("focus-blur"), size)), 0.9);
  const double blurred = contrast(Lens(6.5, only("focus-blur=2"), size));
  EXPECT_LT(blurred, 0.9);
  EXPECT_LT(contrast(Lens(6.5, only("focus-blur=4"), size)), blurred);
  EXPECT_GT(contrast(Lens(10, only("focus-blur=2"), size)), 0.9);
}

TEST(Lens, IsWipedByACloth) {
  const Effects e = only("wipe");
  EXPECT_EQ(contrast(Lens(4.9, e, size)), 1);
  // The cloth comes from the left at 5 s, is in the middle at 5.3 s, and is gone at 5.6 s.
  EXPECT_LT(Lens(5.05, e, size).lost({150, 60}), 0.5);
  EXPECT_EQ(Lens(5.3, e, size).lost({80, 60}), 1);
  EXPECT_LT(contrast(Lens(5.3, e, size)), 0.05);
  EXPECT_LT(contrast(Lens(5.8, e, size)), 0.7);  // wet
  EXPECT_GT(contrast(Lens(7.15, e, size)), 0.95);
  EXPECT_EQ(contrast(Lens(8, e, size)), 1);
}

}  // namespace
}  // namespace csd::sim
