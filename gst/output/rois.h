// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <gst/video/video.h>

#include <optional>

#include "track/types.h"

namespace csd {

/// A rectangle of whole pixels of a frame.
struct Box {
  int x = 0, y = 0, width = 0, height = 0;
};

/// Where the patches of features lie in a frame.
class PatchBoxes {
 public:
  /// In the frame that `info` describes. `crop` may be null; `lines`: the picture's height, which is the crop
  /// rectangle's. `patch_size` is the setting, in pixels of the picture; 0: the default for its height.
  PatchBoxes(const GstVideoInfo &info, const GstVideoCropMeta *crop, int lines, unsigned patch_size);

  /// The square around a point of the picture, clipped to the frame. Nothing where it lies outside.
  std::optional<Box> around(double x, double y) const;
  /// The pixel of the frame that a point of the picture lies in. Nothing where it lies outside.
  std::optional<cv::Point> pixel(double x, double y) const;

 private:
  int width_, height_;
  double left_, top_, side_;
};

/// Attaches a GstVideoRegionOfInterestMeta of type `csdtrack` to `buffer` for each feature that claims a position: its
/// box.
void attach_rois(GstBuffer *buffer, const PatchBoxes &boxes, const Tracks &tracks);

}  // namespace csd
