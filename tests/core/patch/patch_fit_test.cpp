// SPDX-License-Identifier: LGPL-2.1-or-later
#include "patch/patch_fit.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "core/patch/patch_offsets.h"
#include "core/patch/warped_picture.h"
#include "core/simd_targets.h"

namespace csd {
namespace {

using test::for_each_offset;
using test::on_all_targets;

constexpr int radius = PatchPlane::radius;

/// T = 2x + 3y + 5 sin(x y / 7) with weights 1, but ½ in the upper half. Its analytic gradients replace central
/// differences.
AnchorLevel anchor() {
  AnchorLevel a;
  for_each_offset([&](int x, int y) {
    const double phase = x * y / 7.;
    a.patch.at(x, y) = static_cast<float>(2 * x + 3 * y + 5 * std::sin(phase));
    a.gradient_x.at(x, y) = static_cast<float>(2 + 5. / 7 * y * std::cos(phase));
    a.gradient_y.at(x, y) = static_cast<float>(3 + 5. / 7 * x * std::cos(phase));
    a.weight.at(x, y) = y < 0 ? .5F : 1.F;
  });
  return a;
}

PatchPlane ones() {
  PatchPlane p;
  for_each_offset([&](int x, int y) { p.at(x, y) = 1; });
  return p;
}

TEST(PatchFit, OfAnExactPatchIsExact) {
  const AnchorLevel a = anchor();
  PatchPlane value, robust = ones();
  for_each_offset([&](int x, int y) { value.at(x, y) = .5F * a.patch.at(x, y) + 40; });
  PatchFit fit;
  fit_patch_scalar(a, value, a.weight, robust, fit);
  EXPECT_NEAR(fit.gain, .5, 1e-5);
  EXPECT_NEAR(fit.bias, 40, 1e-4);
  EXPECT_NEAR(fit.noise, 0, 1e-4);
  EXPECT_DOUBLE_EQ(fit.weight, 10 * 21 * .5 + 11 * 21);
  EXPECT_NEAR(fit.inliers, fit.weight, 1e-6);
  EXPECT_EQ(fit.counted, 441);
  for (const double g : fit.gradient) EXPECT_NEAR(g, 0, .01);
  // Σ w Tx², Σ w T·yTy, Σ w xTx·Ty, in another order.
  double xx = 0, t_yty = 0, xtx_ty = 0;
  for_each_offset([&](int x, int y) {
    const double w = a.weight.at(x, y), tx = a.gradient_x.at(x, y), ty = a.gradient_y.at(x, y);
    xx += w * tx * tx, t_yty += w * a.patch.at(x, y) * y / 10 * ty, xtx_ty += w * x / 10. * tx * ty;
  });
  EXPECT_NEAR(fit.matrix[6][6], xx, 1e-6 * xx);
  EXPECT_NEAR(fit.matrix[0][5], t_yty, 1e-6 * std::abs(t_yty));
  EXPECT_NEAR(fit.matrix[2][7], xtx_ty, 1e-6 * std::abs(xtx_ty));
  EXPECT_EQ(fit.drift, 0);
}

TEST(PatchFit, ResidualsGiveNoiseWeightsAndGradient) {
  const AnchorLevel a = anchor();
  PatchPlane value, robust = ones();
  // Residuals of either sign are equally likely, so by symmetry gain and bias are known to within the noise.
  cv::RNG rng(1);
  for_each_offset([&](int x, int y) {
    value.at(x, y) = a.patch.at(x, y) + static_cast<float>(rng.gaussian(6));
    if (x > 7) value.at(x, y) += 200;  // outliers: 63 of 441
  });
  PatchFit fit;
  for (int k = 0; k < 20; ++k) fit_patch_scalar(a, value, a.weight, robust, fit);
  EXPECT_NEAR(fit.gain, 1, .05);
  EXPECT_NEAR(fit.bias, 0, 1);
  std::vector<double> sizes;
  for_each_offset(
      [&](int x, int y) { sizes.push_back(std::abs((value.at(x, y) - fit.bias) / fit.gain - a.patch.at(x, y))); });
  auto sorted = sizes;
  std::sort(sorted.begin(), sorted.end());
  EXPECT_NEAR(fit.noise, 1.48 * sorted[220], 1e-4);
  double inliers = 0, gy = 0;
  std::size_t i = 0;
  for_each_offset([&](int x, int y) {
    const double r = (value.at(x, y) - fit.bias) / fit.gain - a.patch.at(x, y);
    const double w = a.weight.at(x, y) / std::pow(1 + std::pow(r / (3 * fit.noise), 2), 2);
    EXPECT_NEAR(robust.at(x, y) * a.weight.at(x, y), w, 1e-5);
    inliers += w;
    gy += w * r * a.gradient_y.at(x, y);
    ++i;
  });
  EXPECT_NEAR(fit.inliers, inliers, 1e-3);
  EXPECT_NEAR(fit.gradient[7], gy, 1e-3 * std::abs(gy) + 1e-2);
  EXPECT_LT(robust.at(9, 0), .05);
}

TEST(PatchFit, NoiseComesFromWeightedSamples) {
  AnchorLevel a = anchor();
  PatchPlane value, robust = ones(), weight = ones();
  for_each_offset([&](int x, int y) {
    const bool masked = x < 1;  // more than half of the patch, with residuals of 90
    weight.at(x, y) = masked ? .2F : 1;
    value.at(x, y) = a.patch.at(x, y) + (masked ? 90.F : (x + y) % 2 ? 3.F : -3.F);
  });
  PatchFit fit;
  for (int k = 0; k < 30; ++k) fit_patch_scalar(a, value, weight, robust, fit);
  EXPECT_EQ(fit.counted, 10 * 21);
  EXPECT_NEAR(fit.noise, 1.48 * 3, .3);
}

TEST(PatchFit, KeepsTheMatrixWhileWeightsStay) {
  const AnchorLevel a = anchor();
  PatchPlane value = a.patch, robust = ones();
  PatchFit fit;
  fit_patch_scalar(a, value, a.weight, robust, fit);
  fit.matrix[0][0] = -1;
  fit_patch_scalar(a, value, a.weight, robust, fit);
  EXPECT_EQ(fit.matrix[0][0], -1);
  for (int x = 3; x <= radius; ++x)
    for (int y = -radius; y <= radius; ++y) value.at(x, y) += 150;
  fit_patch_scalar(a, value, a.weight, robust, fit);
  EXPECT_GT(fit.matrix[0][0], 0);
}

TEST(PatchFit, TheGainHasAFloor) {
  const AnchorLevel a = anchor();
  PatchPlane robust = ones(), value;
  PatchFit fit;
  fit_patch_scalar(a, value, a.weight, robust, fit);  // all black
  EXPECT_FLOAT_EQ(static_cast<float>(fit.gain), smallest_gain);
  for_each_offset([&](int x, int y) { value.at(x, y) = -a.patch.at(x, y); });
  fit_patch_scalar(a, value, a.weight, robust, fit);
  EXPECT_FLOAT_EQ(static_cast<float>(fit.gain), smallest_gain);
}

TEST(PatchFit, MomentsAreAsComputedByHand) {
  AnchorLevel a;
  PatchPlane value, weight;
  // Three samples: T = 1, 2, 3 with weights 1, 1, 2; I = 10, 30, 20. Means 2.25 and 20.
  const float T[] = {1, 2, 3}, I[] = {10, 30, 20}, w[] = {1, 1, 2};
  for (int i = 0; i < 3; ++i) a.patch.at(i, 4) = T[i], value.at(i, 4) = I[i], weight.at(i, 4) = w[i];
  const PatchMoments m = patch_moments_scalar(a, value, weight);
  EXPECT_DOUBLE_EQ(m.weight, 4);
  EXPECT_DOUBLE_EQ(m.anchor_variance, (1.5625 + .0625 + 2 * .5625) / 4);
  EXPECT_DOUBLE_EQ(m.frame_variance, 50);
  EXPECT_DOUBLE_EQ(m.covariance, (12.5 - 2.5) / 4);
  EXPECT_EQ(patch_moments_scalar(a, value, {}).weight, 0);
}

TEST(PatchFit, AgreesWithItsPlainTwin) {
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
        fit_patch_scalar(a, value, weight, plain_robust, plain);
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

// The noise is exact where the weights don't depend on it, so no error in the matrix can hide behind a tolerance.
TEST(PatchFit, TheMatrixOfAnExactFitIsExact) {
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
    fit_patch_scalar(a, a.patch, weight, same, plain);
    for (std::size_t i = 0; i < unknowns; ++i)
      for (std::size_t j = i; j < unknowns; ++j)
        EXPECT_NEAR(fit.matrix[i][j], plain.matrix[i][j], 1e-5 * std::sqrt(plain.matrix[i][i] * plain.matrix[j][j]));
  });
}

TEST(PatchFit, WithoutWeightThereIsNoNoise) {
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

TEST(PatchFit, MomentsAgreeWithTheirPlainTwin) {
  on_all_targets([] {
    cv::RNG rng(9);
    AnchorLevel a;
    PatchPlane value, weight;
    for_each_offset([&](int x, int y) {
      a.patch.at(x, y) = rng.uniform(-30.F, 30.F);
      value.at(x, y) = rng.uniform(199.9F, 200.1F);
      weight.at(x, y) = rng.uniform(0.F, 1.F);
    });
    const PatchMoments m = patch_moments(a, value, weight), plain = patch_moments_scalar(a, value, weight);
    EXPECT_NEAR(m.weight, plain.weight, 1e-3);
    EXPECT_NEAR(m.frame_variance, plain.frame_variance, 1e-5 * plain.frame_variance);
    EXPECT_NEAR(m.anchor_variance, plain.anchor_variance, 1e-5 * plain.anchor_variance);
    EXPECT_NEAR(m.covariance, plain.covariance, 1e-5 * std::sqrt(plain.frame_variance * plain.anchor_variance));
    EXPECT_EQ(patch_moments(a, value, {}).weight, 0);
  });
}

}  // namespace
}  // namespace csd
