// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <opencv2/core.hpp>

#include <array>
#include <cstdint>
#include <vector>

#include "sim/fragments.h"

namespace csd::sim {

/// A picture that repeats in both directions, at all scales: a mipmap pyramid with trilinear sampling.
class TextureMap {
 public:
  static constexpr int granularity = 64;  ///< sides are multiples of it

  TextureMap() = default;
  TextureMap(TextureMap &&) = default;
  TextureMap &operator=(TextureMap &&) = default;
  TextureMap(const TextureMap &) = delete;  // levels point into their data
  TextureMap &operator=(const TextureMap &) = delete;

  /// `texture` is CV_8UC4 (B, G, R and the tissue's gloss), both sides multiples of 64, periodic in both directions;
  /// `texels_per_unit` > 0. Its centre lies at (0, 0) units. Throws std::invalid_argument.
  TextureMap(const cv::Mat &texture, double texels_per_unit);

  /// B, G, R and gloss, 0…255, at (u, v) units for a pixel of 2^`units_log2` units.
  std::array<float, 4> sample(float u, float v, float units_log2) const;
  /// The same for each of `n` fragments, vectorised, with identical bits.
  void sample_row(const Fragment *fragments, std::size_t n, std::array<float, 4> *out) const;

  /// A level of the pyramid, as used by the kernels.
  struct Level {
    std::int32_t width = 0, height = 0;
    std::size_t stride = 0;  ///< bytes; each row and column is followed by a copy of the first
    float per_unit = 0;
    float middle_x = 0, middle_y = 0;  ///< centre of the texture, texels: centres at integers
    float inverse_width = 0, inverse_height = 0;
    const std::uint8_t *data = nullptr;
  };

 private:
  float bias_ = 0;
  std::vector<Level> levels_;
  std::vector<std::vector<std::uint8_t>> data_;  // of the levels
};

/// Multiplies details smaller than about `size` texels by `contrast` in a CV_8UC4 texture; the fourth channel stays.
void scale_pattern(cv::Mat &texture, double size, double contrast);

/// A picture as a periodic texture, mirrored at its edges, so that there are no seams.
struct PictureTexture {
  TextureMap map;
  cv::Size picture;
  double units_per_pixel_x = 0, units_per_pixel_y = 0;

  /// The place of a picture's pixel (centres at integers) on the surface, units.
  cv::Point2d on_surface(cv::Point2d pixel) const {
    return {(pixel.x - 0.5 * (picture.width - 1)) * units_per_pixel_x,
            (pixel.y - 0.5 * (picture.height - 1)) * units_per_pixel_y};
  }
};

/// Scales `bgr` (CV_8UC3, Catmull–Rom) to a height of `units` units at about `texels_per_unit`, with its centre at (0,
/// 0) and the same `gloss` (0…255) everywhere; a `contrast` below 1 fades its pattern. Throws std::invalid_argument if
/// the picture is empty, of another type, or has an aspect ratio of 16 or more, wide or high.
PictureTexture texture_of_picture(const cv::Mat &bgr, double units, double texels_per_unit, std::uint8_t gloss,
                                  double contrast);

}  // namespace csd::sim
