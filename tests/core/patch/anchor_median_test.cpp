// SPDX-License-Identifier: LGPL-2.1-or-later
#include "patch/anchor_median.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/patch/patch_offsets.h"
#include "core/patch/warped_picture.h"
#include "core/simd_targets.h"

namespace csd {
namespace {

using test::for_each_offset;
using test::on_all_targets;

PatchSample texture(double gain, double bias) {
  const test::Waves waves(5, 6, 30, 20);
  PatchSample s;
  for_each_offset([&](int x, int y) {
    s.value.at(x, y) = static_cast<float>(gain * waves.at(x, y) + bias);
    s.weight.at(x, y) = 1;
  });
  return s;
}

// The highlight covers a fifth of the patch in every third sample, including the first, whose brightness the others are
// adjusted to. Brightness and contrast change all the time.
TEST(AnchorMedian, APassingHighlightLeavesNoTrace) {
  AnchorMedian median;
  for (int k = 0; k < 12; ++k) {
    PatchSample s = texture(k ? .7 + .04 * k : 1, 100 - 3 * k);
    for_each_offset([&](int x, int y) {
      if (k % 3 == 0 && std::hypot(x - k / 3, y + 2 - k / 3) < 5.2) s.value.at(x, y) = 250;
    });
    median.add(s);
  }
  EXPECT_EQ(median.size(), 12u);
  const AnchorLevel found = median.make(), clean = make_anchor_level(texture(1, 100));
  // The highlight changes the mean, and nothing else.
  const float offset = found.patch.at(-9, 9) - clean.patch.at(-9, 9);
  EXPECT_NEAR(offset, 0, .2);
  for_each_offset([&](int x, int y) {
    EXPECT_NEAR(found.patch.at(x, y) - offset, clean.patch.at(x, y), .2) << x << ' ' << y;
    EXPECT_EQ(found.weight.at(x, y), 1);
  });
}

TEST(AnchorMedian, ReducesNoise) {
  AnchorMedian median;
  cv::RNG rng(3);
  for (int k = 0; k < 13; ++k) {
    PatchSample s = texture(1, 100);
    for_each_offset([&](int x, int y) { s.value.at(x, y) += static_cast<float>(rng.gaussian(3)); });
    median.add(s);
  }
  const AnchorLevel found = median.make(), clean = make_anchor_level(texture(1, 100));
  double sum = 0;
  for_each_offset([&](int x, int y) { sum += std::pow(found.patch.at(x, y) - clean.patch.at(x, y), 2); });
  // A median of n has the deviation σ·√(π/2n), 1.04 for thirteen. Gains misled by noise would add to it.
  EXPECT_NEAR(std::sqrt(sum / PatchPlane::pixels), 1.04, .05);
}

TEST(AnchorMedian, MaskedInMoreThanTwoThirdsIsMasked) {
  AnchorMedian median;
  for (int k = 0; k < 12; ++k) {
    PatchSample s = texture(1, 100);
    if (k < 8) s.weight.at(2, 3) = 0, s.value.at(2, 3) = 255;
    if (k < 9) s.weight.at(-4, 5) = 0, s.value.at(-4, 5) = 255;
    median.add(s);
  }
  const AnchorLevel found = median.make(), clean = make_anchor_level(texture(1, 100));
  EXPECT_EQ(found.weight.at(2, 3), 1);
  EXPECT_NEAR(found.patch.at(2, 3), clean.patch.at(2, 3), .1);  // from the four that saw it
  EXPECT_EQ(found.weight.at(-4, 5), 0);
  EXPECT_EQ(found.shown.at(-4, 5), 0);
  EXPECT_EQ(found.weight.at(0, 0), 1);
}

TEST(AnchorMedian, BrightInEachSampleIsTextureAndInMostAHighlight) {
  constexpr float bright = GlareWeights::highlight / 255.F;
  AnchorMedian median;
  for (int k = 0; k < 12; ++k) {
    PatchSample s = texture(1, 100);
    s.weight.at(7, 7) = k < 9 ? bright : 1, s.value.at(7, 7) = 250;
    s.weight.at(7, 8) = bright, s.value.at(7, 8) = 250;
    median.add(s);
  }
  const AnchorLevel found = median.make();
  EXPECT_EQ(found.weight.at(7, 7), 0);
  EXPECT_EQ(found.shown.at(7, 7), 0) << "a highlight that left";
  EXPECT_EQ(found.weight.at(7, 8), 0);
  EXPECT_EQ(found.shown.at(7, 8), 1) << "bright in each sample: texture";
  EXPECT_NEAR(found.patch.at(7, 8) - found.patch.at(0, 0), 250 - texture(1, 100).value.at(0, 0), .1);
}

TEST(AnchorMedian, MaskedOrFlatSamplesGiveFiniteValues) {
  PatchSample masked = texture(1, 100), flat;
  masked.weight = {};
  for_each_offset([&](int x, int y) { flat.value.at(x, y) = 80, flat.weight.at(x, y) = 1; });
  for (const PatchSample &s : {masked, flat}) {
    AnchorMedian median;
    for (int k = 0; k < 5; ++k) median.add(s);
    const AnchorLevel a = median.make();
    for_each_offset([&](int x, int y) {
      EXPECT_TRUE(std::isfinite(a.patch.at(x, y)) && std::isfinite(a.gradient_x.at(x, y)));
      EXPECT_EQ(a.weight.at(x, y), s.weight.at(x, y));
    });
  }
}

/// Sample k, with other light, noise, and a highlight, masked or not; some other pixels are masked, too.
PatchSample disturbed(int k, cv::RNG &rng) {
  const double contrast = k % 5 ? 20 : .5, noise = rng.uniform(.3, 6.);
  const test::Waves waves(static_cast<std::uint64_t>(k % 7), 6, 30, contrast);
  const double gain = rng.uniform(.5, 1.6), bias = 100 + rng.uniform(-30., 30.);
  const int cx = rng.uniform(-8, 9), cy = rng.uniform(-8, 9);
  PatchSample s;
  for_each_offset([&](int x, int y) {
    const bool highlight = std::hypot(x - cx, y - cy) < 4;
    s.value.at(x, y) = static_cast<float>(highlight ? 250 : gain * waves.at(x, y) + bias + rng.gaussian(noise));
    s.weight.at(x, y) = (highlight && k % 2) || (k % 3 == 0 && rng.uniform(0.F, 1.F) < .4F) ? rng.uniform(0.F, .9F) : 1;
  });
  return s;
}

TEST(AnchorMedian, TheCompactFormAgreesWithItsPlainTwin) {
  on_all_targets([] {
    cv::RNG rng(11);
    for (int k = 0; k < 20; ++k) {
      auto s = disturbed(k, rng);
      s.value.at(k - 10, 3) = 300, s.value.at(k - 10, 4) = -5;
      const auto found = compact(s), plain = compact_scalar(s);
      EXPECT_EQ(found.value, plain.value);
      EXPECT_EQ(found.weight, plain.weight);
    }
  });
}

// The twin takes ten rounds in double precision with exact medians. The difference is an affine function of grey
// levels, so it is compared where most of them are: within three deviations of their middle.
TEST(AnchorMedian, AdjustsBrightnessLikeItsPlainTwin) {
  on_all_targets([] {
    for (int k = 0; k < 200; ++k) {
      cv::RNG rng(static_cast<std::uint64_t>(k) + 1);
      const auto first = compact(disturbed(k, rng));
      auto found = compact(disturbed(k, rng)), plain = found;
      bring_to(first, found);
      bring_to_scalar(first, plain);
      for_each_offset([&](int x, int y) {
        const auto i = PatchPlane::index(x, y);
        const double mine = found.value[i] * CompactPatch::unit, theirs = plain.value[i] * CompactPatch::unit;
        if (theirs > 40 && theirs < 160) {
          EXPECT_NEAR(mine, theirs, .1) << k << ' ' << x << ' ' << y;
        }
      });
    }
  });
}

TEST(AnchorMedian, MediansAgreeWithThePlainTwin) {
  on_all_targets([] {
    cv::RNG rng(7);
    for (std::size_t n = 1; n <= AnchorMedian::most; ++n) {
      std::vector<CompactPatch> samples;
      for (std::size_t k = 0; k < n; ++k) samples.push_back(compact(disturbed(static_cast<int>(k + n), rng)));
      for (auto &s : samples) s.weight[PatchPlane::index(2, 2)] = 0;
      const auto found = median_of(samples), plain = median_of_scalar(samples);
      EXPECT_EQ(found.value.data, plain.value.data) << n;
      EXPECT_EQ(found.weight.data, plain.weight.data) << n;
      EXPECT_EQ(found.weight.at(2, 2), 0);
    }
  });
}

}  // namespace
}  // namespace csd
