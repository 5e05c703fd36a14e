// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <opencv2/core.hpp>

#include <array>
#include <cstdint>
#include <functional>
#include <vector>

#include "base/types.h"

namespace csd {

/// A marker for one state with its id beside it, used by both overlays.
struct Sprite {
  cv::Mat4b rgba;                  ///< R G B A, colour premultiplied by alpha
  cv::Point origin;                ///< the sprite's pixel that lies on the feature
  std::vector<cv::Range> covered;  ///< per row, the columns that aren't fully transparent; may be empty
};

/// The look of the overlay for one picture height. Colour (Okabe and Ito's palette, distinct in all common forms of
/// colour blindness) and shape show the state; a dark halo keeps it legible on bright tissue: learning a yellow
/// diamond, tracked a sky-blue circle with a dot, occluded an orange square, lost a small grey cross, out a small grey
/// triangle. An ended feature has no marker.
class Markers {
 public:
  /// Rasterises the digits once. `lines` is the picture's height, ≥ 1.
  explicit Markers(int lines);

  int lines() const { return lines_; }
  /// Draws at each call; SpriteCache caches the results. `state` must not be ended.
  Sprite sprite(FeatureState state, FeatureId id, bool text_left = false) const;
  /// Whether the id must be left of a feature at `x` to be legible in a picture of `width` pixels.
  bool text_left(FeatureId id, double x, int width) const;
  /// A cache key, unique for each sprite() result.
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
