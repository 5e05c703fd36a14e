// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <gst/video/video.h>

#include <memory>

#include "base/types.h"

namespace csd {

/// overlay=draw: the markers of Markers, blended into the picture in its own format.
///
/// Each component is blended on its own grid: a luma sample with its pixel's alpha, a chroma sample with the mean alpha
/// of its pixels. Samples that no marker covers are not written. One object per thread.
class OverlayPainter {
 public:
  OverlayPainter();
  ~OverlayPainter();

  /// Draws all features except `ended` ones. `frame` is mapped for reading and writing with `caps`, in any format of
  /// drawable_formats(). Positions refer to picture_area(frame, caps, crop), and nothing outside it is drawn. Sprites
  /// are cached until the picture's height, the kind of format or the colorimetry changes. Returns the number of lines
  /// that could not be drawn into: see paint_rows(). If there are too many sprites to cache, a line may count often.
  int draw(GstVideoFrame &frame, const GstVideoInfo &caps, const GstVideoCropMeta *crop, const Tracks &tracks);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace csd
