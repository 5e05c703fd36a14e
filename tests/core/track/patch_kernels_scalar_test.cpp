// SPDX-License-Identifier: LGPL-2.1-or-later
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "core/track/warped_picture.h"
#include "track/patch_kernels.h"

namespace csd {
namespace {

constexpr int radius = PatchPlane::radius;

template <class Visit>
void for_each_offset(Visit visit) {
  for (int y = -radius; y <= radius; ++y)
    for (int x = -radius; x <= radius; ++x) visit(x, y);
}

/// T = 2x + 3y + 5 sin(x y / 7) with weights 1, but ½ in the upper half; its analytic gradients stand in for central
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

TEST(ScalarKernels, FitOfAnExactPatch) {
  const AnchorLevel a = anchor();
  PatchPlane value, robust = ones();
  for_each_offset([&](int x, int y) { value.at(x, y) = .5F * a.patch.at(x, y) + 40; });
  PatchFit fit;
  scalar::fit_patch(a, value, a.weight, robust, fit);
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

TEST(ScalarKernels, ResidualsGiveNoiseWeightsAndGradient) {
  const AnchorLevel a = anchor();
  PatchPlane value, robust = ones();
  // Residuals of both signs alike: no effect on the gain or bias by symmetry within the noise, thus known but for that.
  cv::RNG rng(1);
  for_each_offset([&](int x, int y) {
    value.at(x, y) = a.patch.at(x, y) + static_cast<float>(rng.gaussian(6));
    if (x > 7) value.at(x, y) += 200;  // outliers: 63 of 441
  });
  PatchFit fit;
  for (int k = 0; k < 20; ++k) scalar::fit_patch(a, value, a.weight, robust, fit);
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

TEST(ScalarKernels, NoiseComesFromWhatHasWeight) {
  AnchorLevel a = anchor();
  PatchPlane value, robust = ones(), weight = ones();
  for_each_offset([&](int x, int y) {
    const bool masked = x < 1;  // more than half of the patch, with residuals of 90
    weight.at(x, y) = masked ? .2F : 1;
    value.at(x, y) = a.patch.at(x, y) + (masked ? 90.F : (x + y) % 2 ? 3.F : -3.F);
  });
  PatchFit fit;
  for (int k = 0; k < 30; ++k) scalar::fit_patch(a, value, weight, robust, fit);
  EXPECT_EQ(fit.counted, 10 * 21);
  EXPECT_NEAR(fit.noise, 1.48 * 3, .3);
}

TEST(ScalarKernels, TheMatrixIsKeptWhileWeightsStay) {
  const AnchorLevel a = anchor();
  PatchPlane value = a.patch, robust = ones();
  PatchFit fit;
  scalar::fit_patch(a, value, a.weight, robust, fit);
  fit.matrix[0][0] = -1;
  scalar::fit_patch(a, value, a.weight, robust, fit);
  EXPECT_EQ(fit.matrix[0][0], -1);
  for (int x = 3; x <= radius; ++x)
    for (int y = -radius; y <= radius; ++y) value.at(x, y) += 150;
  scalar::fit_patch(a, value, a.weight, robust, fit);
  EXPECT_GT(fit.matrix[0][0], 0);
}

TEST(ScalarKernels, GainHasAFloor) {
  const AnchorLevel a = anchor();
  PatchPlane robust = ones(), value;
  PatchFit fit;
  scalar::fit_patch(a, value, a.weight, robust, fit);  // all black
  EXPECT_FLOAT_EQ(static_cast<float>(fit.gain), smallest_gain);
  for_each_offset([&](int x, int y) { value.at(x, y) = -a.patch.at(x, y); });
  scalar::fit_patch(a, value, a.weight, robust, fit);
  EXPECT_FLOAT_EQ(static_cast<float>(fit.gain), smallest_gain);
}

TEST(ScalarKernels, MomentsByHand) {
  AnchorLevel a;
  PatchPlane value, weight;
  // Three samples: T = 1, 2, 3 with weights 1, 1, 2; I = 10, 30, 20. Means 2.25 and 20.
  const float T[] = {1, 2, 3}, I[] = {10, 30, 20}, w[] = {1, 1, 2};
  for (int i = 0; i < 3; ++i) a.patch.at(i, 4) = T[i], value.at(i, 4) = I[i], weight.at(i, 4) = w[i];
  const PatchMoments m = scalar::patch_moments(a, value, weight);
  EXPECT_DOUBLE_EQ(m.weight, 4);
  EXPECT_DOUBLE_EQ(m.anchor_variance, (1.5625 + .0625 + 2 * .5625) / 4);
  EXPECT_DOUBLE_EQ(m.frame_variance, 50);
  EXPECT_DOUBLE_EQ(m.covariance, (12.5 - 2.5) / 4);
  EXPECT_EQ(scalar::patch_moments(a, value, {}).weight, 0);
}

}  // namespace
}  // namespace csd
