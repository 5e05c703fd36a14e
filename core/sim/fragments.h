// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <opencv2/core.hpp>

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <vector>

namespace csd::sim {

/// What a pixel shows of the surface, or a corner of the mesh knows about it. Floats alone: all are interpolated alike.
struct Fragment {
  enum Value : std::size_t {
    depth,  ///< units along the camera's axis
    u,
    v,         ///< the surface's coordinates, units
    level,     ///< log₂ of units per pixel
    gain,      ///< of the light
    normal_x,  ///< of the surface, along the picture's axes; 0,0 faces the camera's axis
    normal_y,
    sheet,     ///< which of Sheets it is; negative: the bed
    blood,     ///< how far inside the pool, in widths of its edge: covered from 0.5 on, free at −0.5
    water,     ///< likewise
    changed,   ///< likewise, of tissue that looks different for good
    motion_x,  ///< pixels that the surface moves while the shutter is open
    motion_y,
    count
  };
  std::array<float, 16> value{};  // 16, not `count`: four vectors of four floats

  float operator[](Value i) const { return value[i]; }
  float &operator[](Value i) { return value[i]; }
};

/// A part of a grid: what belongs to one sheet.
struct Part {
  static constexpr std::uint8_t nobody = 255;

  const std::vector<std::uint8_t> &owners;  ///< of each corner; a cell with a corner of `nobody` is not drawn
  std::uint8_t owner;                       ///< whose part it is
  std::function<bool(float u, float v)> belongs = {};  ///< within the cells that several share; none: all of each
};

/// The nearest surface for each pixel.
class Fragments {
 public:
  static constexpr float nothing = 1e9F;  ///< depth where there is no surface

  void reset(cv::Size size);

  /// Draws a grid of corners, `columns` × `rows`, as triangles. `image` holds their positions in pixels, `corners` the
  /// rest. Only the first `used` (rounded up to 4) values are interpolated. With a `part` only that is drawn.
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
  std::vector<cv::Point> snapped_;  // the corners' positions in 1/256 pixel
};

}  // namespace csd::sim
