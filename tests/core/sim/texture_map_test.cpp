// SPDX-License-Identifier: LGPL-2.1-or-later
#include "sim/texture_map.h"

#include <gtest/gtest.h>

#include <stdexcept>

#include "sim/texture_sampling.h"

namespace csd::sim {
namespace {

cv::Mat noise(cv::Size size = {128, 64}) {
  cv::Mat texture(size, CV_8UC4);
  cv::RNG(9).fill(texture, cv::RNG::UNIFORM, 0, 256);
  return texture;
}

TEST(TextureMap, HasItsTexelsAtTheirPlaces) {
  const cv::Mat texture = noise();
  const TextureMap map(texture, 2);
  for (const cv::Point texel : {cv::Point(0, 0), {64, 32}, {127, 63}, {31, 50}}) {
    // The middle of the texture, between texels 63 and 64, is at 0.
    const auto u = static_cast<float>((texel.x + 0.5 - 64) / 2), v = static_cast<float>((texel.y + 0.5 - 32) / 2);
    for (const float period : {0.0F, 64.0F, -128.0F}) {
      const auto got = map.sample(u + period, v - period, -9);
      for (std::size_t c = 0; c < 4; ++c)
        EXPECT_NEAR(got[c], texture.at<cv::Vec4b>(texel)[static_cast<int>(c)], 0.05) << texel << " " << period;
    }
  }
}

TEST(TextureMap, IsBilinearBetweenTexels) {
  const cv::Mat texture = noise();
  const TextureMap map(texture, 1);
  // A quarter of the way from texel (70, 40) to (71, 40), and half-way to (70, 41).
  const auto got = map.sample(70 + 0.5F - 64 + 0.25F, 40 + 0.5F - 32 + 0.5F, -9);
  for (int c = 0; c < 4; ++c) {
    const auto t = [&](int x, int y) { return static_cast<double>(texture.at<cv::Vec4b>(y, x)[c]); };
    const double expected = 0.5 * (0.75 * t(70, 40) + 0.25 * t(71, 40)) + 0.5 * (0.75 * t(70, 41) + 0.25 * t(71, 41));
    EXPECT_NEAR(got[static_cast<std::size_t>(c)], expected, 1e-3);
  }
}

TEST(TextureMap, FadesToItsMeanFarAway) {
  const cv::Mat texture = noise();
  const TextureMap map(texture, 1);
  const cv::Scalar mean = cv::mean(texture);
  for (int c = 0; c < 4; ++c) EXPECT_NEAR(map.sample(3, 5, 12)[static_cast<std::size_t>(c)], mean[c], 8);
  // Continuously: there is no jump from level to level.
  auto last = map.sample(3, 5, -1);
  for (float level = -1; level < 8; level += 0.01F) {
    const auto now = map.sample(3, 5, level);
    EXPECT_NEAR(now[0], last[0], 3);
    last = now;
  }
}

TEST(TextureMap, SamplesARowInVectorsToTheSameBits) {
  const TextureMap map(noise(), 1.6);
  std::vector<Fragment> row(257);
  cv::RNG rng(2);
  for (auto &f : row) {
    f[Fragment::u] = rng.uniform(-900.0F, 900.0F);
    f[Fragment::v] = rng.uniform(-900.0F, 900.0F);
    f[Fragment::level] = rng.uniform(-3.0F, 9.0F);
  }
  row[5][Fragment::level] = std::numeric_limits<float>::quiet_NaN();
  std::vector<std::array<float, 4>> out(row.size());
  map.sample_row(row.data(), row.size(), out.data());
  for (std::size_t i = 0; i < row.size(); ++i) {
    EXPECT_EQ(out[i], map.sample(row[i][Fragment::u], row[i][Fragment::v], row[i][Fragment::level])) << i;
  }
}

TEST(TextureMap, RefusesATextureThatDoesNotRepeat) {
  EXPECT_THROW(TextureMap(noise({100, 64}), 1), std::invalid_argument);
  EXPECT_THROW(TextureMap(noise(), 0), std::invalid_argument);
  EXPECT_THROW(TextureMap(cv::Mat(64, 64, CV_8UC3, cv::Scalar()), 1), std::invalid_argument);
  EXPECT_THROW(TextureMap(cv::Mat(), 1), std::invalid_argument);
}

TEST(ScalePattern, ScalesOnlySmallDetail) {
  // Columns of 4 texels on a ramp.
  cv::Mat texture(64, 128, CV_8UC4);
  for (int y = 0; y < 64; ++y)
    for (int x = 0; x < 128; ++x) {
      const int v = 60 + (x < 64 ? x : 127 - x) + (x / 2 % 2 != 0 ? 10 : -10);
      texture.at<cv::Vec4b>(y, x) = cv::Vec4b::all(static_cast<std::uint8_t>(v));
    }
  cv::Mat half = texture.clone();
  scale_pattern(half, 24, 0.5);
  for (int x = 20; x < 44; ++x) {
    const int ramp = 60 + x, offset = x / 2 % 2 != 0 ? 5 : -5;
    EXPECT_NEAR(half.at<cv::Vec4b>(10, x)[1], ramp + offset, 1.5) << x;
    EXPECT_EQ(half.at<cv::Vec4b>(10, x)[3], texture.at<cv::Vec4b>(10, x)[3]);
  }
  cv::Mat same = texture.clone();
  scale_pattern(same, 24, 1);
  EXPECT_EQ(cv::norm(same, texture, cv::NORM_INF), 0);
}

TEST(PictureTexture, PutsAPictureOnTheSurface) {
  cv::Mat bgr(48, 80, CV_8UC3);
  for (int y = 0; y < 48; ++y)
    for (int x = 0; x < 80; ++x)
      bgr.at<cv::Vec3b>(y, x) =
          cv::Vec3b(static_cast<std::uint8_t>(2 * x + 20), static_cast<std::uint8_t>(4 * y + 20), 77);
  const PictureTexture t = texture_of_picture(bgr, 600, 1.6, 200, 1);
  // In the picture's middle, and mirrored beyond its edges.
  for (const cv::Point2d pixel : {cv::Point2d(40, 20), {10.5, 40.25}, {70, 5}}) {
    const cv::Point2d uv = t.on_surface(pixel);
    for (const double u : {uv.x, 1000 - uv.x}) {  // the right edge is at 500 units
      const auto got = t.map.sample(static_cast<float>(u), static_cast<float>(uv.y), -9);
      EXPECT_NEAR(got[0], 2 * pixel.x + 20, 1);
      EXPECT_NEAR(got[1], 4 * pixel.y + 20, 1);
      EXPECT_NEAR(got[2], 77, 1e-3);
      EXPECT_NEAR(got[3], 200, 1e-3);
    }
  }
  EXPECT_EQ(t.on_surface({39.5, 23.5}), cv::Point2d(0, 0));
  EXPECT_THROW(texture_of_picture(cv::Mat(), 600, 1, 0, 1), std::invalid_argument);
  const auto line = [](int width, int height) {
    return texture_of_picture(cv::Mat(height, width, CV_8UC3, cv::Scalar::all(9)), 64, 1, 0, 1);
  };
  EXPECT_THROW(line(160, 10), std::invalid_argument);
  EXPECT_THROW(line(10, 160), std::invalid_argument);
  EXPECT_NO_THROW(line(159, 10));
  EXPECT_NO_THROW(line(10, 159));
  EXPECT_THROW(texture_of_picture(cv::Mat(8, 8, CV_8UC1, cv::Scalar(0)), 600, 1, 0, 1), std::invalid_argument);
}

}  // namespace
}  // namespace csd::sim
