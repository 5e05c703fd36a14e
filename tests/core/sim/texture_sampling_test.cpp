// SPDX-License-Identifier: LGPL-2.1-or-later
#include "sim/texture_sampling.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <limits>
#include <opencv2/core.hpp>
#include <vector>

#include "core/simd_targets.h"

namespace csd::sim {
namespace {

/// A level whose texels repeat, with its middle at 0. Points into itself.
struct Texels {
  std::vector<std::uint8_t> data;
  TextureMap::Level level;

  template <typename Value>  // Value(x, y, channel)
  Texels(int width, int height, float per_unit, Value value) {
    level.width = width;
    level.height = height;
    level.stride = 4 * (static_cast<std::size_t>(width) + 1);
    level.per_unit = per_unit;
    level.middle_x = 0.5F * static_cast<float>(width) - 0.5F;
    level.middle_y = 0.5F * static_cast<float>(height) - 0.5F;
    level.inverse_width = 1 / static_cast<float>(width);
    level.inverse_height = 1 / static_cast<float>(height);
    for (int y = 0; y <= height; ++y)
      for (int x = 0; x <= width; ++x)
        for (int c = 0; c < 4; ++c) data.push_back(static_cast<std::uint8_t>(value(x % width, y % height, c)));
    level.data = data.data();
  }
};

int by_place(int x, int y, int c) {
  return 20 * x + 100 * y + c;
}

Fragment fragment(float u, float v, float level) {
  Fragment f;
  f[Fragment::u] = u;
  f[Fragment::v] = v;
  f[Fragment::level] = level;
  return f;
}

TEST(TextureSampling, FloorsBelowZeroToo) {
  EXPECT_EQ(floor_float(2.5F), 2);
  EXPECT_EQ(floor_float(3), 3);
  EXPECT_EQ(floor_float(-2), -2);
  EXPECT_EQ(floor_float(-2.25F), -3);
}

TEST(TextureSampling, FindsTheTexelAndRepeats) {
  const Texels t(4, 2, 2, by_place);  // the middle is texel 1.5, 0.5
  struct {
    float u, v;
    int x, y;
    float fx, fy;
  } const cases[] = {
      {0, 0, 1, 0, 0.5F, 0.5F},     {0.5F, 0.25F, 2, 1, 0.5F, 0}, {2, 0, 1, 0, 0.5F, 0.5F},  // one period later
      {0, 3, 1, 0, 0.5F, 0.5F},     {-1, 0, 3, 0, 0.5F, 0.5F},  // between the last column and the first, repeated
      {0, -0.5F, 1, 1, 0.5F, 0.5F}, {-0.75F, -0.25F, 0, 0, 0, 0},
  };
  for (const auto &c : cases) {
    const TexelPlace place = texel_place(t.level, c.u, c.v);
    EXPECT_EQ(place.upper, t.data.data() + 20 * c.y + 4 * c.x) << c.u << "," << c.v;
    EXPECT_EQ(place.lower, place.upper + 20);
    EXPECT_EQ(place.fx, c.fx) << c.u << "," << c.v;
    EXPECT_EQ(place.fy, c.fy) << c.u << "," << c.v;
  }
}

TEST(TextureSampling, InterpolatesBetweenTwoLevels) {
  struct {
    float level;
    std::size_t fine, coarse;
    float f;
  } const cases[] = {{-1, 0, 0, 0},        {0, 0, 0, 0},         {std::numeric_limits<float>::quiet_NaN(), 0, 0, 0},
                     {1.25F, 1, 2, 0.25F}, {2.75F, 2, 3, 0.75F}, {3, 3, 3, 0},
                     {9, 3, 3, 0}};
  for (const auto &c : cases) {
    const LevelPlace place = level_place(c.level, 4);
    EXPECT_EQ(place.fine, c.fine) << c.level;
    EXPECT_EQ(place.coarse, c.coarse) << c.level;
    EXPECT_EQ(place.f, c.f) << c.level;
  }
}

TEST(TextureSampling, IsTrilinear) {
  const Texels fine(4, 2, 2, by_place), coarse(2, 1, 1, [](int, int, int c) { return 200 + c; });
  const TextureMap::Level levels[] = {fine.level, coarse.level};
  // Texels 1, 2 of both rows: 20, 40, 120, 140, and the channel.
  const Fragment fragments[] = {fragment(0, 0, -3), fragment(0, 0, 0), fragment(0, 0, 5)};
  const float expected[] = {80, 110, 200};  // the level is 0.25 higher: ¼ of the way from 80 to 200
  for (const auto sample : {sample_scalar, sample_vectors}) {
    std::array<float, 4> out[3];
    sample(levels, 2, 0.25F, fragments, 3, out);
    for (std::size_t i = 0; i < 3; ++i)
      for (std::size_t c = 0; c < 4; ++c) EXPECT_FLOAT_EQ(out[i][c], expected[i] + static_cast<float>(c)) << i;
  }
}

void vectors_give_the_bits_of_plain_arithmetic() {
  cv::RNG rng(4);
  const auto noise = [&](int, int, int) { return rng.uniform(0, 256); };
  const Texels a(32, 16, 1.6F, noise), b(16, 8, 0.8F, noise), c(8, 4, 0.4F, noise);
  const TextureMap::Level levels[] = {a.level, b.level, c.level};
  std::vector<Fragment> fragments;
  for (int i = 0; i < 2001; ++i) {
    fragments.push_back(fragment(rng.uniform(-300.0F, 300.0F), rng.uniform(-300.0F, 300.0F), rng.uniform(-2.0F, 4.0F)));
    if (i % 10 == 3) fragments.back()[Fragment::depth] = Fragments::nothing;
  }
  constexpr std::array<float, 4> untouched{-7, -7, -7, -7};
  std::vector<std::array<float, 4>> vectors(fragments.size(), untouched), scalar(fragments.size(), untouched);
  sample_vectors(levels, 3, -0.3F, fragments.data(), fragments.size(), vectors.data());
  sample_scalar(levels, 3, -0.3F, fragments.data(), fragments.size(), scalar.data());
  EXPECT_EQ(vectors, scalar);
  EXPECT_NE(scalar[0], untouched);
  EXPECT_EQ(scalar[3], untouched) << "an empty fragment";
}

TEST(TextureSampling, VectorsGiveTheBitsOfPlainArithmetic) {
  test::on_all_targets(vectors_give_the_bits_of_plain_arithmetic);
}

}  // namespace
}  // namespace csd::sim
