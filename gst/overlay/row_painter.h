// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <gst/video/video.h>

#include <vector>

#include "overlay/blending.h"

namespace csd {

/// Formats that overlay=draw can draw into, in the order of pixel_formats(). Not those with a palette, nor tiles whose
/// packing does not give back what was unpacked.
const std::vector<GstVideoFormat> &drawable_formats();

/// Their caps: caps_of(). Fails only in the first call. The caller owns the result.
GstCaps *drawable_caps();

struct PlacedSprite {
  const NativeSprite &sprite;
  Placement at;
};

/// Blends the sprites into a frame by its format's own unpack and pack functions, line by line, and only into lines
/// that a sprite touches. A chroma sample gets the mean alpha of its pixels.
///
/// A line is left as it is if packing its unpacked pixels would change a byte: it has bits that are no samples. Returns
/// the number of such lines. `frame` is mapped by MappedFrame, for reading and writing.
int paint_rows(GstVideoFrame &frame, const std::vector<PlacedSprite> &sprites);

}  // namespace csd
