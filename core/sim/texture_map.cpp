// SPDX-License-Identifier: LGPL-2.1-or-later
#include "sim/texture_map.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

#include "sim/ieee_math.h"
#include "sim/texture_sampling.h"

namespace csd::sim {
namespace {

// Sharper than the pyramid's theory requires, because its levels are already smooth.
constexpr double sharpen_levels = 0.35;

/// Halves a periodic picture with the binomial [1 3 3 1]², centred where four texels meet.
cv::Mat halved(const cv::Mat &in) {
  const int w = in.cols / 2, h = in.rows / 2;
  cv::Mat out(h, w, CV_8UC4);
  std::vector<int> line(4 * static_cast<std::size_t>(in.cols));
  for (int y = 0; y < h; ++y) {
    const std::uint8_t *r[4];
    for (int k = 0; k < 4; ++k) r[k] = in.ptr((2 * y + k - 1 + in.rows) % in.rows);
    for (std::size_t i = 0; i < line.size(); ++i) line[i] = r[0][i] + 3 * (r[1][i] + r[2][i]) + r[3][i];
    std::uint8_t *o = out.ptr(y);
    for (int x = 0; x < w; ++x) {
      const int at[4] = {(2 * x - 1 + in.cols) % in.cols, 2 * x, 2 * x + 1, (2 * x + 2) % in.cols};
      for (int c = 0; c < 4; ++c) {
        const auto v = [&](int k) { return line[static_cast<std::size_t>(4 * at[k] + c)]; };
        o[4 * x + c] = static_cast<std::uint8_t>((v(0) + 3 * (v(1) + v(2)) + v(3) + 32) >> 6);
      }
    }
  }
  return out;
}

/// Weights to resample from `from` to `to` pixels: four taps per pixel, Catmull–Rom, in 1/1024.
struct Taps {
  std::vector<int> first, weight;
};

Taps taps(int from, int to) {
  Taps t;
  for (int i = 0; i < to; ++i) {
    const double x = (i + 0.5) * from / to - 0.5, k = floor_of(x), f = x - k;
    t.first.push_back(static_cast<int>(k) - 1);
    const double w[4] = {0.5 * (-f + 2 * f * f - f * f * f), 0.5 * (2 - 5 * f * f + 3 * f * f * f),
                         0.5 * (f + 4 * f * f - 3 * f * f * f), 0.5 * (-f * f + f * f * f)};
    int sum = 0;
    for (const double weight : w) {
      t.weight.push_back(static_cast<int>(floor_of(weight * 1024 + 0.5)));
      sum += t.weight.back();
    }
    t.weight[t.weight.size() - 3] += 1024 - sum;
  }
  return t;
}

}  // namespace

TextureMap::TextureMap(const cv::Mat &texture, double texels_per_unit) {
  if (texture.type() != CV_8UC4 || texture.empty() || texture.cols % granularity != 0 ||
      texture.rows % granularity != 0 || !(texels_per_unit > 0)) {
    throw std::invalid_argument("a texture is CV_8UC4, with sides that are multiples of 64");
  }
  bias_ = static_cast<float>(log2_of(texels_per_unit) - sharpen_levels);
  cv::Mat level = texture;
  for (int scale = 1; scale <= granularity; scale *= 2) {
    Level l;
    l.width = level.cols;
    l.height = level.rows;
    l.stride = 4 * (static_cast<std::size_t>(level.cols) + 1);
    l.per_unit = static_cast<float>(texels_per_unit / scale);
    l.middle_x = 0.5F * static_cast<float>(level.cols) - 0.5F;
    l.middle_y = 0.5F * static_cast<float>(level.rows) - 0.5F;
    l.inverse_width = 1 / static_cast<float>(level.cols);
    l.inverse_height = 1 / static_cast<float>(level.rows);
    auto &data = data_.emplace_back(l.stride * (static_cast<std::size_t>(level.rows) + 1));
    for (int y = 0; y <= level.rows; ++y) {
      const std::uint8_t *from = level.ptr(y % level.rows);
      std::uint8_t *to = data.data() + static_cast<std::size_t>(y) * l.stride;
      std::copy_n(from, l.stride - 4, to);
      std::copy_n(from, 4, to + l.stride - 4);
    }
    l.data = data.data();
    levels_.push_back(l);
    if (scale < granularity) level = halved(level);
  }
}

std::array<float, 4> TextureMap::sample(float u, float v, float units_log2) const {
  std::array<float, 4> out;
  Fragment f;
  f[Fragment::u] = u;
  f[Fragment::v] = v;
  f[Fragment::level] = units_log2;
  sample_scalar(levels_.data(), levels_.size(), bias_, &f, 1, &out);
  return out;
}

void TextureMap::sample_row(const Fragment *fragments, std::size_t n, std::array<float, 4> *out) const {
  sample_vectors(levels_.data(), levels_.size(), bias_, fragments, n, out);
}

void scale_pattern(cv::Mat &texture, double size, double contrast) {
  if (contrast == 1) return;
  const int radius = std::max(1, static_cast<int>(size / 2)), width = texture.cols, height = texture.rows;
  const std::int64_t area = static_cast<std::int64_t>(2 * radius + 1) * (2 * radius + 1);
  const auto k = static_cast<int>(floor_of(contrast * 256 + 0.5));
  // Box filter with running sums over columns, then along each row.
  const cv::Mat original = texture.clone();
  std::vector<std::int64_t> columns(3 * static_cast<std::size_t>(width), 0);
  const auto wrap = [](int i, int n) { return ((i % n) + n) % n; };
  const auto add_row = [&](int y, int sign) {
    const std::uint8_t *row = original.ptr(wrap(y, height));
    for (int x = 0; x < width; ++x)
      for (int c = 0; c < 3; ++c) columns[static_cast<std::size_t>(3 * x + c)] += sign * row[4 * x + c];
  };
  for (int y = -radius; y < radius; ++y) add_row(y, 1);
  for (int y = 0; y < height; ++y) {
    add_row(y + radius, 1);
    std::int64_t sum[3] = {};
    const auto column = [&](int x, int c) { return columns[static_cast<std::size_t>(3 * wrap(x, width) + c)]; };
    for (int c = 0; c < 3; ++c)
      for (int x = -radius; x < radius; ++x) sum[c] += column(x, c);
    std::uint8_t *row = texture.ptr(y);
    for (int x = 0; x < width; ++x) {
      for (int c = 0; c < 3; ++c) {
        sum[c] += column(x + radius, c);
        const auto mean = static_cast<int>(sum[c] * 16 / area);  // 1/16 grey levels
        const int value = mean + (row[4 * x + c] * 16 - mean) * k / 256;
        row[4 * x + c] = static_cast<std::uint8_t>(std::clamp((value + 8) >> 4, 0, 255));
        sum[c] -= column(x - radius, c);
      }
    }
    add_row(y - radius, -1);
  }
}

constexpr int longest_side = 16;  // of a picture: maximum aspect ratio

PictureTexture texture_of_picture(const cv::Mat &bgr, double units, double texels_per_unit, std::uint8_t gloss,
                                  double contrast) {
  if (bgr.type() != CV_8UC3 || bgr.empty()) {
    throw std::invalid_argument("the texture must be a picture of 8-bit B, G, R (CV_8UC3) that isn't empty");
  }
  // A line of 30000 pixels would become a texture of gigabytes.
  if (bgr.cols / longest_side >= bgr.rows || bgr.rows / longest_side >= bgr.cols)
    throw std::invalid_argument("the texture must be less than " + std::to_string(longest_side) +
                                " times as wide as high, and as high as wide");
  constexpr int half = TextureMap::granularity / 2;
  const auto side = [&](double length) { return std::max(1, static_cast<int>(floor_of(length / half + 0.5))) * half; };
  const int h = side(units * texels_per_unit), w = side(units * texels_per_unit * bgr.cols / bgr.rows);
  const Taps across = taps(bgr.cols, w), down = taps(bgr.rows, h);

  // Rows first: h × bgr.cols, in 1/16 grey levels.
  cv::Mat rows(h, bgr.cols, CV_16SC3), mirrored(2 * h, 2 * w, CV_8UC4);
  for (int y = 0; y < h; ++y) {
    const auto row = static_cast<std::size_t>(y);
    const std::uint8_t *r[4];
    for (int k = 0; k < 4; ++k) r[k] = bgr.ptr(std::clamp(down.first[row] + k, 0, bgr.rows - 1));
    auto *o = rows.ptr<std::int16_t>(y);
    for (int i = 0; i < 3 * bgr.cols; ++i) {
      int sum = 32;
      for (std::size_t k = 0; k < 4; ++k) sum += down.weight[4 * row + k] * r[k][i];
      o[i] = static_cast<std::int16_t>(sum >> 6);
    }
  }
  for (int y = 0; y < h; ++y) {
    const auto *r = rows.ptr<std::int16_t>(y);
    for (int x = 0; x < w; ++x) {
      const auto column = static_cast<std::size_t>(x);
      cv::Vec4b texel(0, 0, 0, gloss);
      for (int c = 0; c < 3; ++c) {
        int sum = 1 << 13;
        for (int k = 0; k < 4; ++k) {
          const int at = std::clamp(across.first[column] + k, 0, bgr.cols - 1);
          sum += across.weight[4 * column + static_cast<std::size_t>(k)] * r[3 * at + c];
        }
        texel[c] = static_cast<std::uint8_t>(std::clamp(sum >> 14, 0, 255));
      }
      for (const int yy : {y, -1 - y})
        for (const int xx : {x, -1 - x}) {
          // The picture's centre becomes the texture's.
          mirrored.at<cv::Vec4b>((yy + h / 2 + 2 * h) % (2 * h), (xx + w / 2 + 2 * w) % (2 * w)) = texel;
        }
    }
  }
  PictureTexture result;
  const double per_unit = h / units;
  scale_pattern(mirrored, 30 * per_unit, contrast);
  result.map = TextureMap(mirrored, per_unit);
  result.picture = bgr.size();
  result.units_per_pixel_x = w / per_unit / bgr.cols;
  result.units_per_pixel_y = units / bgr.rows;
  return result;
}

}  // namespace csd::sim
