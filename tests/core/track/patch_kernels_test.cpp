// SPDX-License-Identifier: LGPL-2.1-or-later
#include "track/patch_kernels.h"

#include <gtest/gtest.h>

#include <cmath>
#include <memory>

#include "core/track/simd_targets.h"
#include "core/track/warped_picture.h"

namespace csd {
namespace {

using test::OnTarget;
using test::similarity;

constexpr int radius = PatchPlane::radius;

template <class Visit>
void for_each_offset(Visit visit) {
  for (int y = -radius; y <= radius; ++y)
    for (int x = -radius; x <= radius; ++x) visit(x, y);
}

template <class Test>
void on_all_targets(Test test) {
  for (const std::int64_t target : hwy::SupportedAndGeneratedTargets()) {
    SCOPED_TRACE(hwy::TargetName(target));
    const OnTarget scope(target);
    test();
  }
}

cv::Mat noise16(cv::Size size) {
  cv::Mat m(size, CV_16UC1);
  cv::RNG(1).fill(m, cv::RNG::UNIFORM, 0, 65281);
  return m;
}

// Every pixel is random: a sample from the wrong one would be far off.
TEST(PatchKernels, TilesAreSampledAsTheLevelIs) {
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
      // Sometimes a step on from the last one: the tile stays.
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
      EXPECT_EQ(inside, scalar::sample_patch(level, weights, map, expected_value, expected_weight));
      plain += tile->plain;
      partial += inside > 0 && inside < 1;
      for_each_offset([&](int x, int y) {
        // A coordinate is a sum of floats within the tile: 2e-5 of a pixel, between neighbours up to 255 apart.
        ASSERT_NEAR(value.at(x, y), expected_value.at(x, y), .01) << k << ' ' << x << ' ' << y;
        ASSERT_NEAR(tile->plain ? 1 : weight.at(x, y), expected_weight.at(x, y), 1e-4) << k << ' ' << x << ' ' << y;
      });
    }
    EXPECT_GT(plain, 30);
    EXPECT_GT(too_large, 30);
    EXPECT_GT(partial, 30);
  });
}

TEST(PatchKernels, FitAgreesWithThePlainTwin) {
  on_all_targets([] {
    cv::RNG rng(5);
    for (int k = 0; k < 200; ++k) {
      const test::Waves waves(static_cast<std::uint64_t>(k), 6, 40, k % 4 ? 20 : 2);
      AnchorLevel a;
      PatchPlane value, robust, weight;
      const double noise = k % 3 ? rng.uniform(.5, 20.) : 0, gain = rng.uniform(.05, 2.);
      for_each_offset([&](int x, int y) {
        const auto f = [&](double dx, double dy) { return static_cast<float>(waves.at(x + dx, y + dy)); };
        a.patch.at(x, y) = f(0, 0);
        a.gradient_x.at(x, y) = (f(1, 0) - f(-1, 0)) / 2;
        a.gradient_y.at(x, y) = (f(0, 1) - f(0, -1)) / 2;
        weight.at(x, y) = k % 2 ? 1.F : rng.uniform(0.F, 1.F) < .3F ? 0.F : rng.uniform(0.F, 1.F);
        value.at(x, y) = static_cast<float>(gain * waves.at(x + .3, y - .2) + 100 + rng.gaussian(noise));
        if (k % 7 == 0 && x > 3) value.at(x, y) = 255;
      });
      robust.data.fill(1);
      PatchFit plain;
      PatchPlane plain_robust = robust;
      for (int round = 0; round < 4; ++round) {
        PatchFit fit = plain;
        robust = plain_robust;
        fit_patch(a, value, weight, robust, fit);
        scalar::fit_patch(a, value, weight, plain_robust, plain);
        EXPECT_NEAR(fit.gain, plain.gain, 1e-4 * plain.gain);
        EXPECT_NEAR(fit.bias, plain.bias, 1e-3);
        // |r| is counted in 1/128 grey levels.
        EXPECT_NEAR(fit.noise, plain.noise, .001 * plain.noise + .012) << k;
        EXPECT_NEAR(fit.weight, plain.weight, 1e-2);
        EXPECT_NEAR(fit.inliers, plain.inliers, .01 * plain.inliers);
        EXPECT_EQ(fit.counted, plain.counted);
        for (std::size_t i = 0; i < unknowns; ++i) {
          const double scale = std::sqrt(plain.matrix[i][i] * plain.inliers) * std::max(plain.noise, 1.);
          EXPECT_NEAR(fit.gradient[i], plain.gradient[i], .004 * scale) << k << ' ' << i;
          for (std::size_t j = i; j < unknowns; ++j)
            EXPECT_NEAR(fit.matrix[i][j], plain.matrix[i][j],
                        .02 * std::sqrt(plain.matrix[i][i] * plain.matrix[j][j]) + 1e-3);
        }
      }
    }
  });
}

// The noise is exact where the weights don't depend on it, so that no entry of the matrix can hide behind a tolerance.
TEST(PatchKernels, TheMatrixOfAnExactFit) {
  on_all_targets([] {
    const test::Waves waves(3, 6, 40, 20);
    AnchorLevel a;
    PatchPlane robust, weight;
    cv::RNG rng(2);
    for_each_offset([&](int x, int y) {
      a.patch.at(x, y) = static_cast<float>(waves.at(x, y));
      a.gradient_x.at(x, y) = rng.uniform(-9.F, 9.F);
      a.gradient_y.at(x, y) = rng.uniform(-9.F, 9.F);
      weight.at(x, y) = rng.uniform(0.F, 1.F);
    });
    robust.data.fill(1);
    PatchPlane same = robust;
    PatchFit fit, plain;
    fit_patch(a, a.patch, weight, robust, fit);
    scalar::fit_patch(a, a.patch, weight, same, plain);
    for (std::size_t i = 0; i < unknowns; ++i)
      for (std::size_t j = i; j < unknowns; ++j)
        EXPECT_NEAR(fit.matrix[i][j], plain.matrix[i][j], 1e-5 * std::sqrt(plain.matrix[i][i] * plain.matrix[j][j]));
  });
}

TEST(PatchKernels, NothingThatCountsIsNoNoise) {
  on_all_targets([] {
    AnchorLevel a;
    PatchPlane robust;
    robust.data.fill(1);
    PatchFit fit;
    fit_patch(a, {}, {}, robust, fit);
    EXPECT_EQ(fit.counted, 0);
    EXPECT_EQ(fit.noise, 0);
    EXPECT_EQ(fit.weight, 0);
    for (const double g : fit.gradient) EXPECT_EQ(g, 0);
  });
}

TEST(PatchKernels, MomentsAgreeWithThePlainTwin) {
  on_all_targets([] {
    cv::RNG rng(9);
    AnchorLevel a;
    PatchPlane value, weight;
    for_each_offset([&](int x, int y) {
      a.patch.at(x, y) = rng.uniform(-30.F, 30.F);
      value.at(x, y) = rng.uniform(199.9F, 200.1F);
      weight.at(x, y) = rng.uniform(0.F, 1.F);
    });
    const PatchMoments m = patch_moments(a, value, weight), plain = scalar::patch_moments(a, value, weight);
    EXPECT_NEAR(m.weight, plain.weight, 1e-3);
    EXPECT_NEAR(m.frame_variance, plain.frame_variance, 1e-5 * plain.frame_variance);
    EXPECT_NEAR(m.anchor_variance, plain.anchor_variance, 1e-5 * plain.anchor_variance);
    EXPECT_NEAR(m.covariance, plain.covariance, 1e-5 * std::sqrt(plain.frame_variance * plain.anchor_variance));
    EXPECT_EQ(patch_moments(a, value, {}).weight, 0);
  });
}

TEST(PatchKernels, Multiply) {
  PatchPlane a, b, out;
  for_each_offset([&](int x, int y) { a.at(x, y) = static_cast<float>(x), b.at(x, y) = static_cast<float>(y); });
  multiply(a, b, out);
  for_each_offset([&](int x, int y) { EXPECT_EQ(out.at(x, y), static_cast<float>(x * y)); });
}

}  // namespace
}  // namespace csd
