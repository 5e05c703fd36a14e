// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <gst/video/video.h>

#include <memory>

#include "track/types.h"

namespace csd {

/// overlay=draw: the markers of Markers, blended into the picture in the format that it has.
///
/// Each component is blended on its own grid: a luma sample by the alpha of its pixel, a chroma sample by the mean of
/// the pixels that it colours. Samples that no marker pixel touches are not even written.
/// One object belongs to one thread.
class OverlayPainter {
 public:
  OverlayPainter();
  ~OverlayPainter();

  /// Draws all features but `ended` ones. `frame` is mapped for reading and writing with `caps`, of any format of
  /// CSD_VIDEO_FORMATS; positions are those of picture_area(frame, caps, crop), and nothing outside it is drawn.
  /// Sprites are kept from frame to frame, until the picture's height, the format's kind or its colorimetry changes.
  void draw(GstVideoFrame &frame, const GstVideoInfo &caps, const GstVideoCropMeta *crop, const Tracks &tracks);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace csd
