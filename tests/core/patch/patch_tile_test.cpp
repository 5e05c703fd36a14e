// SPDX-License-Identifier: LGPL-2.1-or-later
#include "patch/patch_tile.h"

#include <gtest/gtest.h>

#include <memory>

#include "core/patch/patch_offsets.h"
#include "core/patch/warped_picture.h"
#include "core/simd_targets.h"

namespace csd {
namespace {

using test::for_each_offset;
using test::on_all_targets;
using test::similarity;

cv::Mat noise16(cv::Size size) {
  cv::Mat m(size, CV_16UC1);
  cv::RNG(1).fill(m, cv::RNG::UNIFORM, 0, 65281);
  return m;
}

// Every pixel is random, so a sample of the wrong pixel would be far off.
TEST(PatchTile, TilesAreSampledAsTheLevelIs) {
  const cv::Mat level = noise16({150, 110});
  cv::Mat glare(level.size(), CV_8UC1, 255);
  const cv::Mat none;
  glare({70, 40, 9, 30}).setTo(0);
  glare({79, 40, 2, 30}).setTo(100);
  on_all_targets([&] {
    cv::RNG rng(7);
    auto tile = std::make_unique<PatchTile>();
    int plain = 0, too_large = 0, partial = 0;
    for (int k = 0; k < 600; ++k) {
      PatchMap map;
      map.step =
          similarity(rng.uniform(-180., 180.), rng.uniform(.1, 2.6)) * cv::Matx22d(1, rng.uniform(-.3, .3), 0, 1);
      // Some maps step on from the last one, within the same tile.
      if (k % 3 == 0) map.origin = {rng.uniform(-20., 170.), rng.uniform(-20., 130.)};
      if (k % 3) map.origin = {75 + rng.uniform(-1., 1.), 50 + rng.uniform(-1., 1.)};
      if (k % 3 != 2) tile->width = 0;
      const cv::Mat &weights = k % 6 < 3 ? glare : none;
      if (!prepare_tile(level, weights, map, *tile)) {
        ++too_large;
        tile->width = 0;
        continue;
      }
      PatchPlane value, weight, expected_value, expected_weight;
      const double inside = sample_tile(*tile, map, value, weight);
      EXPECT_EQ(inside, sample_scalar(level, weights, map, expected_value, expected_weight));
      plain += tile->plain;
      partial += inside > 0 && inside < 1;
      for_each_offset([&](int x, int y) {
        // A coordinate is a sum of floats within the tile: off by 2e-5 of a pixel, between neighbours up to 255 apart.
        ASSERT_NEAR(value.at(x, y), expected_value.at(x, y), .01) << k << ' ' << x << ' ' << y;
        ASSERT_NEAR(tile->plain ? 1 : weight.at(x, y), expected_weight.at(x, y), 1e-4) << k << ' ' << x << ' ' << y;
      });
    }
    EXPECT_GT(plain, 30);
    EXPECT_GT(too_large, 30);
    EXPECT_GT(partial, 30);
  });
}

}  // namespace
}  // namespace csd
