// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <gst/video/video.h>

#include <optional>

#include "base/types.h"

namespace csd {

/// A rectangle of whole pixels of a frame.
struct Box {
  int x = 0, y = 0, width = 0, height = 0;
};

/// The boxes of feature patches in a frame.
class PatchBoxes {
 public:
  /// For the frame in `buffer`, with caps `info`; with a crop rectangle the frame's size is its GstVideoMeta's, if any.
  /// `lines`: height of the picture, which is the crop rectangle's. `patch_size` is the property, in pixels of the
  /// picture; 0: the default for its height.
  PatchBoxes(const GstVideoInfo &info, GstBuffer *buffer, int lines, unsigned patch_size);

  /// The square around a point of the picture, clipped to the frame. Nothing if it lies outside.
  std::optional<Box> around(double x, double y) const;
  /// The pixel of the frame that contains a point of the picture. Nothing if it lies outside.
  std::optional<cv::Point> pixel(double x, double y) const;

 private:
  int width_, height_;
  double left_, top_, side_;
};

/// Attaches a GstVideoRegionOfInterestMeta of type `csdtrack` with its box to `buffer` for each feature that claims a
/// position.
void attach_rois(GstBuffer *buffer, const PatchBoxes &boxes, const Tracks &tracks);

}  // namespace csd
