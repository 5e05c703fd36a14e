// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <opencv2/core.hpp>

#include <array>
#include <cstdint>
#include <vector>

#include "sim/fragments.h"

namespace csd::sim {

/// A picture that repeats without end in both directions, at all scales: a pyramid, sampled trilinearly.
class TextureMap {
 public:
  static constexpr int granularity = 64;  ///< sides are multiples of it

  TextureMap() = default;
  TextureMap(TextureMap &&) = default;
  TextureMap &operator=(TextureMap &&) = default;
  TextureMap(const TextureMap &) = delete;  // levels point into their data
  TextureMap &operator=(const TextureMap &) = delete;

  /// `texture` is CV_8UC4 (B, G, R, and how glossy the tissue is), both sides multiples of 64, the left edge following
  /// on the right one and the top on the bottom; `texels_per_unit` > 0. Its middle lies at (0, 0) units.
  /// Throws std::invalid_argument.
  TextureMap(const cv::Mat &texture, double texels_per_unit);

  /// B, G, R and gloss, 0…255, at (u, v) units for a pixel of 2^`units_log2` units.
  std::array<float, 4> sample(float u, float v, float units_log2) const;
  /// The same for each of `n` fragments, in vectors: the same bits.
  void sample_row(const Fragment *fragments, std::size_t n, std::array<float, 4> *out) const;

  /// A level of the pyramid, as kernels see it.
  struct Level {
    std::int32_t width = 0, height = 0;
    std::size_t stride = 0;  ///< bytes; each row and column is followed by a copy of the first
    float per_unit = 0;
    float middle_x = 0, middle_y = 0;  ///< of the texture, texels: centres at integers
    float inverse_width = 0, inverse_height = 0;
    const std::uint8_t *data = nullptr;
  };

 private:
  float bias_ = 0;
  std::vector<Level> levels_;
  std::vector<std::vector<std::uint8_t>> data_;  // of the levels
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
/// `contrast` below 1 its pattern fades. Throws std::invalid_argument if the picture is empty, of another type, or
/// 16 times as wide as high and more, or as high as wide.
PictureTexture texture_of_picture(const cv::Mat &bgr, double units, double texels_per_unit, std::uint8_t gloss,
                                  double contrast);

}  // namespace csd::sim
