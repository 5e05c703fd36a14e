// SPDX-License-Identifier: LGPL-2.1-or-later
#include "csd2012/learn/colour_choice.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "base/random.h"
#include "csd2012/learn/pixel_ranking.h"

namespace csd {
namespace {

// R + 2G + 2B has one value for the features and another for the rest. R, G and B by themselves are noise.
ColourPatches separable(int n) {
  ColourPatches patches(5);
  Random random(1);
  for (int i = 0; i < n; ++i) {
    cv::Mat m(5, 5, CV_8UC3);
    for (int p = 0; p < 25; ++p) {
      const int g = static_cast<int>(random.below(100)), r = 2 * static_cast<int>(random.below(100));
      const int b = (i % 4 ? 300 : 330) - g - r / 2;
      m.at<cv::Vec3b>(p / 5, p % 5) = {static_cast<std::uint8_t>(std::clamp(b, 0, 255)), static_cast<std::uint8_t>(g),
                                       static_cast<std::uint8_t>(r)};
    }
    patches.add(m, i % 4 ? Label::not_feature : Label::feature);
  }
  return patches;
}

TEST(ColourChoice, FindsTheSpaceThatSeparates) {
  EXPECT_EQ(choose_colour(separable(300)), (ColourSpace{1, 2, 2}));
}

// A second computation of the same scores: single-channel samples and the pixel ranking.
TEST(ColourChoice, ScoresAreMeansOfTheBestPixels) {
  for (const int n : {40, 100, 300}) {
    const ColourPatches patches = separable(n);
    const auto scores = colour_scores(patches);
    for (std::size_t s = 0; s < scores.size(); s += 6) {
      SampleSet set(5);
      std::vector<SampleId> features, others;
      cv::Mat all(static_cast<int>(patches.size()) * 5, 5, CV_8UC1);
      patches.convert(colour_spaces()[s], all);
      for (std::size_t i = 0; i < patches.size(); ++i) {
        const int row = static_cast<int>(i) * 5;
        (patches.label(i) == Label::feature ? features : others)
            .push_back(set.add(all.rowRange(row, row + 5), patches.label(i)));
      }
      NodeSamples node;
      node.gather(set, features, others);
      std::vector<double> v;
      variance_ratios(node, LogTable(node.size()), v);
      std::sort(v.rbegin(), v.rend());
      double sum = 0;
      for (std::size_t k = 0; k < 16; ++k) sum += v[k];
      EXPECT_NEAR(scores[s], sum / 16, 1e-9 * (1 + sum)) << s;
    }
  }
}

// In a feature's lower half, R + 2G + 2B is larger by as much as the brightness varies from patch to patch. So no
// single pixel tells features from the rest, but differences of two do. R, G and B by themselves are noise.
TEST(ColourChoice, WithDifferencesFindsTheSpaceWhosePairsSeparate) {
  ColourPatches patches(5);
  Random random(1);
  for (int i = 0; i < 300; ++i) {
    cv::Mat m(5, 5, CV_8UC3);
    const int brightness = static_cast<int>(random.below(120));
    for (int p = 0; p < 25; ++p) {
      const int g = static_cast<int>(random.below(60)), r = 2 * static_cast<int>(random.below(60));
      const int b = 120 + brightness / 2 + (i % 4 == 0 && p >= 15 ? 60 : 0) - g - r / 2;
      m.at<cv::Vec3b>(p / 5, p % 5) = {static_cast<std::uint8_t>(std::clamp(b, 0, 255)), static_cast<std::uint8_t>(g),
                                       static_cast<std::uint8_t>(r)};
    }
    patches.add(m, i % 4 ? Label::not_feature : Label::feature);
  }
  EXPECT_EQ(choose_colour_of_pairs(patches, random), (ColourSpace{1, 2, 2}));
}

TEST(ColourChoice, TakesIntensityWhereNothingSeparates) {
  ColourPatches patches(3);
  Random random(1);
  EXPECT_EQ(choose_colour(patches), (ColourSpace{1, 1, 1}));
  EXPECT_EQ(choose_colour_of_pairs(patches, random), (ColourSpace{1, 1, 1}));
  patches.add(cv::Mat(3, 3, CV_8UC3, cv::Scalar(1, 2, 3)), Label::feature);
  EXPECT_EQ(choose_colour(patches), (ColourSpace{1, 1, 1}));
  EXPECT_THROW(patches.add(cv::Mat::zeros(3, 3, CV_8UC1), Label::feature), cv::Exception);
}

}  // namespace
}  // namespace csd
