// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <gst/gst.h>

#include <string>
#include <vector>

#include "support/enums.h"
#include "support/property_table.h"

namespace csd {

/// Settings that may change with every frame; small, because they are copied once per frame.
struct LiveSettings {
  GstCsdTrackOverlay overlay = GST_CSD_TRACK_OVERLAY_NONE;
  bool attach_meta = true;
  bool attach_roi = false;
  bool attach_analytics = false;
  GstCsdTrackPostMessages post_messages = GST_CSD_TRACK_POST_MESSAGES_CHANGE;
  GstClockTime message_interval = 0;
  GstCsdTrackOnError on_error = GST_CSD_TRACK_ON_ERROR_ERROR;
  bool navigation = false;
};

/// The values of the properties. A plain value: the element guards its own with the object lock.
struct ElementSettings {
  GstCsdTrackAlgorithm algorithm = GST_CSD_TRACK_ALGORITHM_CSD;
  guint max_features = 50;
  std::string points;
  bool replenish = true;
  GstClockTime forget_after = 10 * GST_SECOND;
  std::string region;
  GstCsdTrackContentArea content_area = GST_CSD_TRACK_CONTENT_AREA_AUTO;
  guint patch_size = 0;
  guint search_radius = 0;
  GstClockTime training_time = GST_SECOND / 2;
  GstCsdTrackLearning learning = GST_CSD_TRACK_LEARNING_ASYNC;
  guint n_threads = 0;
  GstClockTime frame_budget = 0;
  guint64 seed = 1;
  LiveSettings live;
};

/// csdtrack's properties, with the ranges, units and flags that gst-inspect-1.0 shows. `overlay_changed` is called
/// after each setting of `overlay`, and `stats` makes the value of `stats`, both without the object lock.
std::vector<Property<ElementSettings>> track_properties(void (*overlay_changed)(gpointer object),
                                                        void (*stats)(gpointer object, GValue *value));

}  // namespace csd
