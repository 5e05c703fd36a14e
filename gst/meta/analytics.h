// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <gst/video/video.h>

#include <unordered_map>

#include "base/types.h"
#include "meta/rois.h"

namespace csd {

/// Writes tracks as GstAnalytics metadata (gstreamer-analytics ≥ 1.24; key points ≥ 1.30), for elements that only know
/// that. One object per stream.
class Analytics {
 public:
  /// The first so many features of a frame are written. GStreamer keeps one relation meta per buffer, with a byte for
  /// each pair of its entries, and copies it with the frame: 10000 features, of three entries each, would take 900 MB,
  /// and 1000 take 9 MB.
  static constexpr std::size_t max_features = 1000;

  /// Adds to the buffer's relation meta, or a new one, a tracking for each feature, with its id and in running time
  /// when it was first seen and last claimed a position (until then, the former). It is lost unless the feature may
  /// still be in the picture. A feature that claims a position also gets a detection of type `csdtrack`, with its box
  /// and confidence, related to the tracking. With key points the tracking also relates to the feature's point: visible
  /// while a position is claimed; occluded and projected while it is predicted.
  void attach(GstBuffer *buffer, const PatchBoxes &boxes, const Tracks &tracks, GstClockTime running_time);

 private:
  struct Seen {
    GstClockTime first, last;
  };
  std::unordered_map<FeatureId, Seen> seen_;  ///< of the features in the last frame
  bool told_ = false;                         ///< that some are left out
};

}  // namespace csd
