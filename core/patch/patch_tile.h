// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <opencv2/core.hpp>

#include <cstdint>

#include "patch/patch_map.h"
#include "patch/patch_plane.h"

namespace csd {

/// The part of a pyramid level in which a patch moves: copied once for a pass, with the border repeated, so that
/// sampling has no edge to mind. An entry holds a pixel and the one below it: 64 bits from any entry on are the four
/// pixels that a sample lies between.
struct PatchTile {
  static constexpr int side = 64;
  int x0 = 0, y0 = 0;         ///< the first pixel, in the level
  int width = 0, height = 0;  ///< of the filled part; 0: none
  int right = 0, bottom = 0;  ///< the last pixel of the picture, in the tile
  bool within = false;        ///< all of it lies in the picture
  bool plain = false;         ///< and has full weight
  alignas(64) std::uint32_t pixels[side * side];
  alignas(64) std::uint32_t weights[side * side];  ///< unless plain; 1/255
};

/// Fills `tile` with what samples of `map` need, and a margin for steps to come; does nothing if it has that already.
/// False if they need more than the tile can hold. `level` and `weights` as in sample_scalar.
bool prepare_tile(const cv::Mat &level, const cv::Mat &weights, const PatchMap &map, PatchTile &tile);

/// How far beyond the outermost pixels' centres a sample still counts as inside: a rounding error, not a pixel.
inline constexpr double inside_tolerance = 1e-3;

/// 21 × 21 bilinear samples of a prepared tile: grey levels; weights, 0 outside the picture (tile.plain: not written,
/// all 1). Gives the share of the samples that lie in the picture. On the best SIMD target of the machine.
double sample_tile(const PatchTile &tile, const PatchMap &map, PatchPlane &value, PatchPlane &weight);

/// Its plain twin, straight from `level` (CV_16UC1, 1/256 of a grey level) and `weights` (CV_8UC1 of the same size, or
/// empty: all count). Beyond the outermost pixels' centres the border is repeated.
double sample_scalar(const cv::Mat &level, const cv::Mat &weights, const PatchMap &map, PatchPlane &value,
                     PatchPlane &weight);

}  // namespace csd
