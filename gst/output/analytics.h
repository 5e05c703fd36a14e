// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <gst/video/video.h>

#include <unordered_map>

#include "output/rois.h"
#include "track/types.h"

namespace csd {

/// Tracks as GstAnalytics metadata (gstreamer-analytics ≥ 1.24; key points ≥ 1.30), for elements that know only that.
/// Of one stream.
class Analytics {
 public:
  /// Adds to the buffer's relation meta, or a new one, for each feature a tracking of the feature's id: since when it
  /// is known here and when it last claimed a position (else the former), in running time, and lost unless it may still
  /// be in the picture. One that claims a position has also a detection of type `csdtrack`, its box and its confidence;
  /// the two relate to each other. So do, with key points, the tracking and the feature's point: visible where a
  /// position is claimed; occluded, and projected, where it is predicted.
  void attach(GstBuffer *buffer, const PatchBoxes &boxes, const Tracks &tracks, GstClockTime running_time);

 private:
  struct Seen {
    GstClockTime first, last;
  };
  std::unordered_map<FeatureId, Seen> seen_;  ///< of the features in the last frame
};

}  // namespace csd
