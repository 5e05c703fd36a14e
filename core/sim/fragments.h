// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <opencv2/core.hpp>

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <vector>

namespace csd::sim {

/// The surface seen by a pixel, or at a corner of the mesh. Only floats, so that all are interpolated alike.
struct Fragment {
  enum Value : std::size_t {
    depth,  ///< units along the camera's axis
    u,
    v,         ///< the surface's coordinates, units
    level,     ///< log₂ of units per pixel
    gain,      ///< of the light
    normal_x,  ///< of the surface, in the picture's axes; 0,0 faces along the camera's axis
    normal_y,
    sheet,     ///< number of its sheet; negative: the bed
    blood,     ///< distance into the pool, in widths of its edge: covered from 0.5 on, free at −0.5
    water,     ///< likewise
    changed,   ///< likewise, for permanently changed tissue
    motion_x,  ///< motion of the surface during the exposure, pixels
    motion_y,
    count
  };
  std::array<float, 16> value{};  // 16, not `count`: four vectors of four floats

  float operator[](Value i) const { return value[i]; }
  float &operator[](Value i) { return value[i]; }
};

/// The part of a grid that belongs to one sheet.
struct Part {
  static constexpr std::uint8_t nobody = 255;

  const std::vector<std::uint8_t> &owners;  ///< of each corner; a cell with a corner of `nobody` is not drawn
  std::uint8_t owner;                       ///< the sheet of the part
  std::function<bool(float u, float v)> belongs = {};  ///< tests points in shared cells; none: these are drawn whole
};

/// The nearest surface for each pixel.
class Fragments {
 public:
  static constexpr float nothing = 1e9F;  ///< depth of empty pixels

  void reset(cv::Size size);

  /// Draws a grid of corners, `columns` × `rows`, as triangles. `image` has their positions in pixels, `corners` all
  /// other values. Interpolates only the first `used` (rounded up to 4) values. With a `part` draws only that.
  void draw_grid(int columns, int rows, const std::vector<cv::Point2d> &image, const std::vector<Fragment> &corners,
                 std::size_t used, const Part *part = nullptr);

  cv::Size size() const { return size_; }
  const Fragment *row(int y) const {
    return data_.data() + static_cast<std::size_t>(y) * static_cast<std::size_t>(size_.width);
  }
  const Fragment &at(int x, int y) const { return row(y)[x]; }

 private:
  template <std::size_t Groups>
  void draw(int columns, int rows, const std::vector<Fragment> &corners, const Part *part);
  template <std::size_t Groups, bool Shared>
  void draw_triangle(std::size_t a, std::size_t b, std::size_t c, const std::vector<Fragment> &corners,
                     const Part *part);

  cv::Size size_;
  std::vector<Fragment> data_;
  std::vector<cv::Point> snapped_;  // corner positions in 1/256 pixel
};

}  // namespace csd::sim
