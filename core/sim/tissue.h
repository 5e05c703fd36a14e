// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <opencv2/core.hpp>

#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "sim/camera.h"
#include "sim/canvas.h"
#include "sim/fluids.h"
#include "sim/fragments.h"
#include "sim/highlights.h"
#include "sim/light.h"
#include "sim/mesh.h"
#include "sim/surface.h"
#include "sim/texture_map.h"
#include "sim/tools.h"

namespace csd::sim {

/// The tissue as a camera sees it: surface, texture, light, highlights, fluids.
class Tissue {
 public:
  Tissue(const Effects &effects, std::uint64_t seed, TextureMap texture);

  /// Finds the fragment of each pixel at `time` and, with `shutter` > 0 (seconds), its motion during the exposure.
  void find(double time, cv::Size size, double shutter, Fragments &fragments);
  /// Colours the fragments, which must be of the same time.
  void paint(double time, const Fragments &fragments, Canvas &canvas) const;

  /// Projects the surface point (u, v), units, at `time`: pixels and depth.
  cv::Point3d project(double time, cv::Size size, cv::Point2d uv) const;
  /// The same as if it moved with another sheet.
  cv::Point3d project(double time, cv::Size size, cv::Point2d uv, std::uint8_t sheet) const;
  /// The grasping instrument at `time`, if it is near the picture.
  std::optional<Tools::Grip> grip(double time, cv::Size size) const;
  /// The share of a pixel saturated by a highlight, 0…1.
  float blinded(const Camera &camera, const Fragments &fragments, cv::Point pixel) const;

  /// Whether blood or water covers the point (u, v), units.
  bool drowned(double time, cv::Point2d uv) const;

  const Sheets &sheets() const { return surface_.sheets(); }
  bool hollow() const { return surface_.hollow(); }
  /// The sheet of (u, v).
  std::uint8_t sheet_of(cv::Point2d uv) const { return Sheets::sheet_of(sheets().place(uv.x, uv.y)); }

  Camera camera(double time, cv::Size size) const { return camera_at(time, effects_, seed_, size); }

 private:
  struct View;
  /// Draws the mesh's part of a sheet, or the bed.
  void draw(const View &view, int sheet, const Part *part, Fragments &fragments);
  /// Whether a corner of the mesh belongs to the part or is next to it.
  bool touches(const Part &part, std::size_t corner) const;
  template <bool Wet>
  void paint_row(double time, const Camera &camera, const Fragments &fragments, int y, Canvas &canvas) const;
  static float gloss_of(float texture_gloss, const Fragment &f, bool wet);

  Effects effects_;
  std::uint64_t seed_;
  Surface surface_;
  TextureMap texture_;
  Fluids fluids_;
  Highlights highlights_;
  Mesh mesh_;
  std::vector<cv::Point2d> image_;
  std::vector<Fragment> corners_;
  std::vector<std::uint8_t> owners_;  // of the corners
};

/// Blurs along the motion during the exposure. `copy` is scratch.
void blur_motion(const Fragments &fragments, Canvas &canvas, Canvas &copy);

}  // namespace csd::sim
