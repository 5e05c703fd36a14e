// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <gst/gst.h>

#include <string>

#include "support/enums.h"
#include "track/types.h"

namespace csd {

/// Ids of csdtrack's properties. Those up to `last_structural` shape the tracker: they take effect at READY→PAUSED and
/// are read-only from PAUSED on; the others may change with every frame.
enum Property : guint {
  prop_0,
  prop_algorithm,
  prop_max_features,
  prop_points,
  prop_points_array,
  prop_replenish,
  prop_forget_after,
  prop_region,
  prop_region_array,
  prop_content_area,
  prop_patch_size,
  prop_search_radius,
  prop_training_time,
  prop_learning,
  prop_n_threads,
  prop_frame_budget,
  prop_seed,
  prop_overlay,
  prop_attach_meta,
  prop_attach_roi,
  prop_attach_analytics,  // only installed if built
  prop_post_messages,
  prop_message_interval,
  prop_on_error,
  prop_navigation,
  prop_stats,
  last_structural = prop_seed
};

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

/// Installs every property of `Property`, with the ranges, units and flags that gst-inspect-1.0 shows.
void install_properties(GObjectClass *klass);

/// Returns false if `id` is not a writable property.
bool set_property(ElementSettings &settings, guint id, const GValue &value);
/// Returns false if `id` is not a property of these settings.
bool get_property(const ElementSettings &settings, guint id, GValue &value);

/// The core's settings. If a text property can't be parsed, `error` says why.
Settings core_settings(const ElementSettings &settings, std::string &error);

/// The number of threads for `n-threads`: 0 is one fewer than the number of processors, at least 1.
unsigned thread_count(guint n_threads);

}  // namespace csd
