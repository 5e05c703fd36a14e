// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <opencv2/core.hpp>

#include <array>
#include <cstdint>
#include <functional>
#include <vector>

#include "track/types.h"

namespace csd {

/// A marker with its id beside it, for one state: what both overlays show.
struct Sprite {
  cv::Mat4b rgba;                  ///< R G B A, colour premultiplied by alpha
  cv::Point origin;                ///< the pixel of the sprite that lies on the feature
  std::vector<cv::Range> covered;  ///< per row, columns that are not wholly transparent; may be empty
};

/// The look of the overlay, for pictures of one height. State is told by colour (Okabe and Ito's palette, told apart in
/// all common forms of colour blindness) and by shape; a dark halo keeps it legible on bright tissue:
/// learning a yellow diamond, tracked a sky-blue circle with a dot, occluded an orange square, lost a small grey cross,
/// out a small grey triangle. An ended feature has no marker.
class Markers {
 public:
  /// Digits are rasterised here, once. `lines` is the picture's height, ≥ 1.
  explicit Markers(int lines);

  int lines() const { return lines_; }
  /// Drawn at each call: SpriteCache keeps them. `state` must not be ended.
  Sprite sprite(FeatureState state, FeatureId id, bool text_left = false) const;
  /// Whether the id must stand left of a feature at `x` to be read in a picture of `width` pixels.
  bool text_left(FeatureId id, double x, int width) const;
  /// A key for caches of sprites: one for each that sprite() can give.
  static std::uint64_t key(FeatureState state, FeatureId id, bool text_left);

 private:
  struct Glyph {
    cv::Mat1f core, halo;
  };
  Glyph draw(cv::Size size, int stroke, const std::function<void(cv::Mat1b &, int thickness)> &shape) const;

  int lines_;
  int radius_, stroke_, halo_, text_height_, digit_advance_;
  std::array<Glyph, 10> digits_;
  std::array<Glyph, feature_states> shapes_;
};

}  // namespace csd
