// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <opencv2/core.hpp>

#include <array>
#include <cstdint>
#include <vector>

namespace csd::sim {

/// A picture that repeats without end in both directions, at all scales: a pyramid, sampled trilinearly.
class TextureMap {
 public:
  static constexpr int granularity = 64;  ///< sides are multiples of it

  TextureMap() = default;

  /// `texture` is CV_8UC4 (B, G, R, and how glossy the tissue is), both sides multiples of 64, the left edge following
  /// on the right one and the top on the bottom; `texels_per_unit` > 0. Its middle lies at (0, 0) units.
  /// Throws std::invalid_argument.
  TextureMap(const cv::Mat &texture, double texels_per_unit);

  double texels_per_unit() const { return texels_per_unit_; }
  cv::Size size() const { return levels_.empty() ? cv::Size() : levels_[0].size; }

  /// B, G, R and gloss, 0…255, at (u, v) units for a pixel of 2^`units_log2` units.
  std::array<float, 4> sample(float u, float v, float units_log2) const {
    const float level = units_log2 + bias_;
    if (level <= 0) return bilinear(levels_[0], u, v);
    const float top = static_cast<float>(levels_.size() - 1);
    if (level >= top) return bilinear(levels_.back(), u, v);
    const auto below = static_cast<std::size_t>(level);
    const float f = level - static_cast<float>(below);
    const auto a = bilinear(levels_[below], u, v), b = bilinear(levels_[below + 1], u, v);
    std::array<float, 4> result;
    for (std::size_t c = 0; c < 4; ++c) result[c] = a[c] + f * (b[c] - a[c]);
    return result;
  }

 private:
  struct Level {
    cv::Size size;
    std::size_t stride = 0;  // bytes; each row and column is followed by a copy of the first
    float per_unit = 0;
    float middle_x = 0, middle_y = 0;  // of the texture, texels: centres at integers
    float inverse_width = 0, inverse_height = 0;
    std::vector<std::uint8_t> data;
  };

  static std::array<float, 4> bilinear(const Level &l, float u, float v) {
    const auto width = static_cast<float>(l.size.width), height = static_cast<float>(l.size.height);
    float x = u * l.per_unit + l.middle_x, y = v * l.per_unit + l.middle_y;
    x -= floor_of(x * l.inverse_width) * width;
    y -= floor_of(y * l.inverse_height) * height;
    // Rounding may have left x just outside.
    int ix = static_cast<int>(x), iy = static_cast<int>(y);
    ix = ix < 0 ? 0 : ix >= l.size.width ? l.size.width - 1 : ix;
    iy = iy < 0 ? 0 : iy >= l.size.height ? l.size.height - 1 : iy;
    const float fx = x - static_cast<float>(ix), fy = y - static_cast<float>(iy);
    const std::uint8_t *p = l.data.data() + static_cast<std::size_t>(iy) * l.stride + 4 * static_cast<std::size_t>(ix);
    const std::uint8_t *q = p + l.stride;
    const float w11 = fx * fy, w10 = fy - w11, w01 = fx - w11, w00 = 1 - fx - w10;
    std::array<float, 4> result;
    for (std::size_t c = 0; c < 4; ++c) {
      result[c] = w00 * static_cast<float>(p[c]) + w01 * static_cast<float>(p[c + 4]) + w10 * static_cast<float>(q[c]) +
                  w11 * static_cast<float>(q[c + 4]);
    }
    return result;
  }

  static float floor_of(float x) {
    const auto i = static_cast<float>(static_cast<int>(x));
    return i > x ? i - 1 : i;
  }

  double texels_per_unit_ = 1;
  float bias_ = 0;
  std::vector<Level> levels_;
};

/// Multiplies by `contrast` what is smaller than about `size` texels in a CV_8UC4 texture; its fourth channel stays.
void scale_pattern(cv::Mat &texture, double size, double contrast);

/// A picture as a texture that repeats: mirrored at its edges, so that nothing jumps.
struct PictureTexture {
  TextureMap map;
  cv::Size picture;
  double units_per_pixel_x = 0, units_per_pixel_y = 0;

  /// Where a pixel of the picture (centres at integers) lies on the surface, units.
  cv::Point2d on_surface(cv::Point2d pixel) const {
    return {(pixel.x - 0.5 * (picture.width - 1)) * units_per_pixel_x,
            (pixel.y - 0.5 * (picture.height - 1)) * units_per_pixel_y};
  }
};

/// `bgr` (CV_8UC3) scaled (Catmull–Rom) to a height of `units` units at about `texels_per_unit`, its middle at (0, 0);
/// `gloss` (0…255) holds for all of it; with a
/// `contrast` below 1 its pattern fades. Throws std::invalid_argument if the picture is empty or of another type.
PictureTexture texture_of_picture(const cv::Mat &bgr, double units, double texels_per_unit, std::uint8_t gloss,
                                  double contrast);

}  // namespace csd::sim
