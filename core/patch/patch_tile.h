// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <opencv2/core.hpp>

#include <cstdint>

#include "patch/patch_map.h"
#include "patch/patch_plane.h"

namespace csd {

/// The part of a pyramid level around a patch, copied once per alignment with the border replicated, so that sampling
/// needs no bounds checks. An entry holds a pixel and the one below it: 64 bits starting at any entry are the four
/// neighbours of a sample.
struct PatchTile {
  static constexpr int side = 64;
  int x0 = 0, y0 = 0;         ///< the first pixel, in the level
  int width = 0, height = 0;  ///< of the filled part; 0: none
  int right = 0, bottom = 0;  ///< the last pixel of the picture, in the tile
  bool within = false;        ///< lies entirely in the picture
  bool plain = false;         ///< and has full weight everywhere
  alignas(64) std::uint32_t pixels[side * side];
  alignas(64) std::uint32_t weights[side * side];  ///< 1/255; unused if plain
};

/// Fills `tile` with the pixels that the samples of `map` need, and a margin for later steps; does nothing if it has
/// them already. False if they do not fit. `level` and `weights` as in sample_scalar.
bool prepare_tile(const cv::Mat &level, const cv::Mat &weights, const PatchMap &map, PatchTile &tile);

/// How far outside the outermost pixels' centres a sample still counts as inside: tolerance for rounding errors.
inline constexpr double inside_tolerance = 1e-3;

/// 21 × 21 bilinear samples of a prepared tile: grey levels and weights, 0 outside the picture (with tile.plain weights
/// are all 1 and not written). Returns the share of the samples inside the picture. On the machine's best SIMD target.
double sample_tile(const PatchTile &tile, const PatchMap &map, PatchPlane &value, PatchPlane &weight);

/// The same without SIMD, directly from `level` (CV_16UC1, 1/256 of a grey level) and `weights` (CV_8UC1 of the same
/// size, or empty: all 1). Outside the outermost pixels' centres the border is replicated.
double sample_scalar(const cv::Mat &level, const cv::Mat &weights, const PatchMap &map, PatchPlane &value,
                     PatchPlane &weight);

}  // namespace csd
