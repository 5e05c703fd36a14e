// SPDX-License-Identifier: LGPL-2.1-or-later
#include "csd2012/learn/smoke.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>

namespace csd {
namespace {

TEST(Smoke, Equation1IsAsComputedByHand) {
  // .75·100 + .25·.6·255 = 113.25; as printed .25·100 + .75·.6·255 = 139.75
  EXPECT_EQ(smoke_pixel(100, .25, .6), 113);
  EXPECT_EQ(smoke_pixel(100, .25, .6, SmokeEquation::as_printed), 140);
  EXPECT_EQ(smoke_pixel(37, 0, .6), 37);
  EXPECT_EQ(smoke_pixel(37, 1, 1), 255);
  EXPECT_EQ(smoke_pixel(37, 1, 0), 0);
}

TEST(Smoke, TheFieldHasMeanZeroVarianceOneAndAGaussiansCorrelation) {
  Random random(1);
  const Smoke smoke(21, random);
  const auto &f = smoke.field();
  const auto n = static_cast<std::size_t>(smoke.field_size());
  ASSERT_EQ(f.size(), n * n);
  double sum = 0, squares = 0, at5 = 0, at60 = 0;
  for (std::size_t y = 0; y < n; ++y)
    for (std::size_t x = 0; x < n; ++x) {
      const double v = f[y * n + x];
      sum += v;
      squares += v * v;
      at5 += v * f[y * n + (x + 5) % n];
      at60 += v * f[y * n + (x + 60) % n];
    }
  const double count = static_cast<double>(n * n);
  EXPECT_NEAR(sum / count, 0, 1e-9);
  EXPECT_NEAR(squares / count, 1, 1e-9);
  // White noise under a Gaussian of σ = 21/4 has the autocorrelation exp(−r²/4σ²): .797 at 5 px, 0 far away.
  EXPECT_NEAR(at5 / count, std::exp(-25 / (4 * 5.25 * 5.25)), .05);
  EXPECT_NEAR(at60 / count, 0, .2);
}

TEST(Smoke, PatchesHaveTheRequestedDensity) {
  // On black, P′ = d·C·255, so the mean over many patches is E[d]·E[C]·255.
  Random random(2);
  const Smoke smoke(21, random);
  for (const double density : smoke_densities) {
    double sum = 0;
    constexpr int patches = 400;
    for (int i = 0; i < patches; ++i) {
      cv::Mat patch = cv::Mat::zeros(21, 21, CV_8UC3);
      smoke.apply(patch, density, random);
      sum += cv::mean(patch)[0];
      EXPECT_EQ(cv::mean(patch)[0], cv::mean(patch)[2]);  // C is equal in R, G, B
    }
    EXPECT_NEAR(sum / patches, density * .6 * 255, 2.5) << density;
  }
}

// d ~ N(.4, .05), C ~ N(.6, .1). Neighbouring pixels have nearly the same d and C. A black and a white one become p =
// d·C and q = 1 − d·(1 − C) (in 0…1), which give d = 1 − (q − p) and C = p/d.
TEST(Smoke, DensityAndColourAreDistributedAsInThePaper) {
  EXPECT_EQ(smoke_densities, (std::array<double, 3>{.15, .25, .4}));
  Random random(4);
  const Smoke smoke(21, random);
  double d_sum = 0, d_squares = 0, c_sum = 0, c_squares = 0, product = 0;
  constexpr int patches = 20000;
  for (int i = 0; i < patches; ++i) {
    cv::Mat patch(1, 2, CV_8UC3, cv::Scalar::all(0));
    patch.at<cv::Vec3b>(0, 1) = {255, 255, 255};
    smoke.apply(patch, .4, random);
    const double p = patch.at<cv::Vec3b>(0, 0)[0] / 255.0, q = patch.at<cv::Vec3b>(0, 1)[0] / 255.0;
    const double d = 1 - (q - p), c = p / d;
    d_sum += d;
    d_squares += d * d;
    c_sum += c;
    c_squares += c * c;
    product += d * c;
  }
  const double d_mean = d_sum / patches, c_mean = c_sum / patches;
  const double d_deviation = std::sqrt(d_squares / patches - d_mean * d_mean);
  const double c_deviation = std::sqrt(c_squares / patches - c_mean * c_mean);
  EXPECT_NEAR(d_mean, .4, .005);
  EXPECT_NEAR(d_deviation, .05, .006);
  EXPECT_NEAR(c_mean, .6, .01);
  EXPECT_NEAR(c_deviation, .1, .012);
  // Both come from different places of the field, so they are uncorrelated.
  EXPECT_NEAR((product / patches - d_mean * c_mean) / (d_deviation * c_deviation), 0, .3);
}

TEST(Smoke, ChangesTheOrderOfPixels) {
  Random random(3);
  const Smoke smoke(21, random);
  int changed = 0;
  for (int i = 0; i < 50; ++i) {
    cv::Mat patch(21, 21, CV_8UC3, cv::Scalar::all(100));
    patch.at<cv::Vec3b>(2, 2) = {104, 104, 104};
    smoke.apply(patch, .4, random);
    changed += patch.at<cv::Vec3b>(2, 2)[0] < patch.at<cv::Vec3b>(18, 18)[0];
  }
  EXPECT_GT(changed, 5);
  EXPECT_LT(changed, 45);
}

TEST(Smoke, TheSameSeedGivesTheSameSmoke) {
  const auto smoked = [](std::uint64_t seed) {
    Random random(seed);
    const Smoke smoke(9, random);
    cv::Mat patch(9, 9, CV_8UC3, cv::Scalar(10, 90, 200));
    smoke.apply(patch, .25, random);
    return patch;
  };
  EXPECT_EQ(cv::norm(smoked(1), smoked(1), cv::NORM_L1), 0);
  EXPECT_GT(cv::norm(smoked(1), smoked(2), cv::NORM_L1), 0);
  Random random(1);
  cv::Mat gray = cv::Mat::zeros(9, 9, CV_8UC1);
  EXPECT_THROW(Smoke(9, random).apply(gray, .25, random), cv::Exception);
}

}  // namespace
}  // namespace csd
