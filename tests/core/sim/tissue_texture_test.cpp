// SPDX-License-Identifier: LGPL-2.1-or-later
#include "sim/tissue_texture.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <stdexcept>

namespace csd::sim {
namespace {

TEST(Style, NamesAreParsedBack) {
  std::set<std::string_view> names;
  for (std::size_t i = 0; i < style_count; ++i) {
    const auto style = static_cast<Style>(i);
    EXPECT_EQ(parse_style(style_name(style)), style);
    names.insert(style_name(style));
  }
  EXPECT_EQ(names.size(), style_count);
  try {
    parse_style("spleen");
    FAIL();
  } catch (const std::invalid_argument &e) {
    for (const auto name : names) EXPECT_NE(std::string(e.what()).find(name), std::string::npos) << e.what();
  }
}

struct Look {
  // Means; the deviation within patches of 21 units, and that of the patches' means.
  double blue = 0, green = 0, red = 0, small = 0, large = 0;
};

Look look(const TextureMap &map) {
  Look l;
  std::vector<double> within;
  double sum_means = 0, sum_squares = 0;
  int patches = 0;
  for (int v = -600; v < 600; v += 60)
    for (int u = -600; u < 600; u += 60) {
      double sum = 0, squares = 0;
      for (int y = 0; y < 21; y += 2)
        for (int x = 0; x < 21; x += 2) {
          const auto t = map.sample(static_cast<float>(u + x), static_cast<float>(v + y), 0);
          l.blue += t[0];
          l.green += t[1];
          l.red += t[2];
          const double luma = 0.114 * t[0] + 0.587 * t[1] + 0.299 * t[2];
          sum += luma;
          squares += luma * luma;
        }
      const double mean = sum / 121;
      within.push_back(std::sqrt(std::max(squares / 121 - mean * mean, 0.0)));
      sum_means += mean;
      sum_squares += mean * mean;
      ++patches;
    }
  const double n = 121.0 * patches;
  l.blue /= n;
  l.green /= n;
  l.red /= n;
  std::nth_element(within.begin(), within.begin() + static_cast<std::ptrdiff_t>(within.size() / 2), within.end());
  l.small = within[within.size() / 2];
  l.large = std::sqrt(sum_squares / patches - sum_means * sum_means / patches / patches);
  return l;
}

TEST(TissueTexture, IsRedAndFadesWithoutLosingItsForms) {
  for (std::size_t i = 0; i < style_count; ++i) {
    const auto style = static_cast<Style>(i);
    const Look full = look(tissue_texture(style, 2, 1024)), faint = look(tissue_texture(style, 2, 1024, 0.25));
    if (style <= Style::charred) {  // speckle is grey, and cartilage nearly
      EXPECT_GT(full.red, 1.15 * full.green) << style_name(style);
      EXPECT_GT(full.red, 1.15 * full.blue) << style_name(style);
    }
    // In the later styles, most patches lie within a lobe, a crust or between vessels, and have little pattern to lose.
    EXPECT_LT(faint.small, (style > Style::fat ? 0.6 : 0.5) * full.small) << style_name(style);
    if (style != Style::speckle) {  // it has no forms but its dots
      EXPECT_GT(faint.large, 0.6 * full.large) << style_name(style);
    }
  }
}

TEST(TissueTexture, DependsOnSeedAndStyle) {
  const auto pixel = [](Style style, std::uint64_t seed) { return tissue_texture(style, seed, 256).sample(31, 7, 0); };
  EXPECT_EQ(pixel(Style::heart, 1), pixel(Style::heart, 1));
  EXPECT_NE(pixel(Style::heart, 1), pixel(Style::heart, 2));
  EXPECT_NE(pixel(Style::heart, 1), pixel(Style::bowel, 1));
}

TEST(TissueTexture, RefusesSidesThatAreNoPowersOfTwo) {
  EXPECT_THROW(tissue_texture(Style::liver, 1, 1000), std::invalid_argument);
  EXPECT_THROW(tissue_texture(Style::liver, 1, 128), std::invalid_argument);
}

}  // namespace
}  // namespace csd::sim
