// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <opencv2/core.hpp>

#include <cstdint>
#include <memory>
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

namespace csd::sim {

/// The tissue as a camera sees it: surface, texture, light, highlights, fluids.
class Tissue {
 public:
  Tissue(const Effects &effects, std::uint64_t seed, TextureMap texture);

  /// What each pixel of the picture shows at `time`. With `shutter` > 0 (seconds) also how far it moves meanwhile.
  void find(double time, cv::Size size, double shutter, Fragments &fragments);
  /// Its colours. `fragments` are of the same time.
  void paint(double time, const Fragments &fragments, Canvas &canvas) const;

  /// Where the surface point (u, v), units, is at `time`: pixels, and depth.
  cv::Point3d project(double time, cv::Size size, cv::Point2d uv) const;
  /// How much of a pixel a highlight blinds, 0…1.
  float blinded(const Camera &camera, const Fragments &fragments, cv::Point pixel) const;

  /// Whether blood or water covers the point (u, v), units.
  bool drowned(double time, cv::Point2d uv) const;

  Camera camera(double time, cv::Size size) const { return camera_at(time, effects_, seed_, size); }

 private:
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
};

/// Blurs what moved while the shutter was open, along its motion. `copy` is scratch.
void blur_motion(const Fragments &fragments, Canvas &canvas, Canvas &copy);

}  // namespace csd::sim
