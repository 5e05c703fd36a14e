// SPDX-License-Identifier: LGPL-2.1-or-later
#include "support/settings.h"

#include <algorithm>
#include <thread>
#include <type_traits>

#include "support/presets.h"
#include "support/value_arrays.h"
#include "text/parse.h"

namespace csd {
namespace {

AlgorithmKind algorithm_of(GstCsdTrackAlgorithm algorithm) {
  switch (algorithm) {
    case GST_CSD_TRACK_ALGORITHM_LK:
      return AlgorithmKind::lk;
    case GST_CSD_TRACK_ALGORITHM_MS1:
      return AlgorithmKind::ms1;
    case GST_CSD_TRACK_ALGORITHM_MS2:
      return AlgorithmKind::ms2;
    case GST_CSD_TRACK_ALGORITHM_SIFT:
      return AlgorithmKind::sift;
    case GST_CSD_TRACK_ALGORITHM_CSD_FOREST:
      return AlgorithmKind::csd_forest;
    case GST_CSD_TRACK_ALGORITHM_CSD:
      return AlgorithmKind::csd;
    case GST_CSD_TRACK_ALGORITHM_CSD_2012:
      break;
  }
  return AlgorithmKind::csd_2012;
}

}  // namespace

bool set_property(ElementSettings &s, guint id, const GValue &value) {
  const auto as_enum = [&value](auto &target) {
    target = static_cast<std::remove_reference_t<decltype(target)>>(g_value_get_enum(&value));
  };
  switch (id) {
    case prop_algorithm:
      as_enum(s.algorithm);
      return true;
    case prop_max_features:
      s.max_features = g_value_get_uint(&value);
      return true;
    case prop_points:
      s.points = preset_text(g_value_get_string(&value));
      return true;
    case prop_points_array:
      s.points = points_text(value);
      return true;
    case prop_replenish:
      s.replenish = g_value_get_boolean(&value);
      return true;
    case prop_forget_after:
      s.forget_after = g_value_get_uint64(&value);
      return true;
    case prop_region:
      s.region = preset_text(g_value_get_string(&value));
      return true;
    case prop_region_array:
      s.region = region_text(value);
      return true;
    case prop_content_area:
      as_enum(s.content_area);
      return true;
    case prop_patch_size:
      s.patch_size = g_value_get_uint(&value);
      return true;
    case prop_search_radius:
      s.search_radius = g_value_get_uint(&value);
      return true;
    case prop_training_time:
      s.training_time = g_value_get_uint64(&value);
      return true;
    case prop_learning:
      as_enum(s.learning);
      return true;
    case prop_n_threads:
      s.n_threads = g_value_get_uint(&value);
      return true;
    case prop_frame_budget:
      s.frame_budget = g_value_get_uint64(&value);
      return true;
    case prop_seed:
      s.seed = g_value_get_uint64(&value);
      return true;
    case prop_overlay:
      as_enum(s.live.overlay);
      return true;
    case prop_attach_meta:
      s.live.attach_meta = g_value_get_boolean(&value);
      return true;
    case prop_attach_roi:
      s.live.attach_roi = g_value_get_boolean(&value);
      return true;
    case prop_attach_analytics:
      s.live.attach_analytics = g_value_get_boolean(&value);
      return true;
    case prop_post_messages:
      as_enum(s.live.post_messages);
      return true;
    case prop_message_interval:
      s.live.message_interval = g_value_get_uint64(&value);
      return true;
    case prop_on_error:
      as_enum(s.live.on_error);
      return true;
    case prop_navigation:
      s.live.navigation = g_value_get_boolean(&value);
      return true;
    default:
      return false;
  }
}

bool get_property(const ElementSettings &s, guint id, GValue &value) {
  switch (id) {
    case prop_algorithm:
      g_value_set_enum(&value, s.algorithm);
      return true;
    case prop_max_features:
      g_value_set_uint(&value, s.max_features);
      return true;
    case prop_points:
      g_value_set_string(&value, s.points.c_str());
      return true;
    case prop_points_array:
      set_points(value, s.points);
      return true;
    case prop_replenish:
      g_value_set_boolean(&value, s.replenish);
      return true;
    case prop_forget_after:
      g_value_set_uint64(&value, s.forget_after);
      return true;
    case prop_region:
      g_value_set_string(&value, s.region.c_str());
      return true;
    case prop_region_array:
      set_region(value, s.region);
      return true;
    case prop_content_area:
      g_value_set_enum(&value, s.content_area);
      return true;
    case prop_patch_size:
      g_value_set_uint(&value, s.patch_size);
      return true;
    case prop_search_radius:
      g_value_set_uint(&value, s.search_radius);
      return true;
    case prop_training_time:
      g_value_set_uint64(&value, s.training_time);
      return true;
    case prop_learning:
      g_value_set_enum(&value, s.learning);
      return true;
    case prop_n_threads:
      g_value_set_uint(&value, s.n_threads);
      return true;
    case prop_frame_budget:
      g_value_set_uint64(&value, s.frame_budget);
      return true;
    case prop_seed:
      g_value_set_uint64(&value, s.seed);
      return true;
    case prop_overlay:
      g_value_set_enum(&value, s.live.overlay);
      return true;
    case prop_attach_meta:
      g_value_set_boolean(&value, s.live.attach_meta);
      return true;
    case prop_attach_roi:
      g_value_set_boolean(&value, s.live.attach_roi);
      return true;
    case prop_attach_analytics:
      g_value_set_boolean(&value, s.live.attach_analytics);
      return true;
    case prop_post_messages:
      g_value_set_enum(&value, s.live.post_messages);
      return true;
    case prop_message_interval:
      g_value_set_uint64(&value, s.live.message_interval);
      return true;
    case prop_on_error:
      g_value_set_enum(&value, s.live.on_error);
      return true;
    case prop_navigation:
      g_value_set_boolean(&value, s.live.navigation);
      return true;
    default:
      return false;
  }
}

Settings core_settings(const ElementSettings &s, std::string &error) {
  Settings core;
  core.points_from_start = is_truth(s.points);
  auto points = core.points_from_start ? Parsed<std::vector<cv::Point2d>>{} : parse_points(s.points);
  const auto region = parse_region(s.region);
  error = !points ? points.error : region.error;
  core.algorithm = algorithm_of(s.algorithm);
  core.max_features = s.max_features;
  core.points = std::move(points.value);
  core.replenish = s.replenish;
  core.forget_after = static_cast<std::int64_t>(s.forget_after);
  core.region = region.value;
  core.content_area = s.content_area == GST_CSD_TRACK_CONTENT_AREA_FULL ? ContentArea::full : ContentArea::automatic;
  core.patch_size = s.patch_size;
  core.search_radius = s.search_radius;
  core.training_time = static_cast<std::int64_t>(s.training_time);
  core.learn_synchronously = s.learning == GST_CSD_TRACK_LEARNING_SYNC;
  core.frame_budget = static_cast<std::int64_t>(s.frame_budget);
  core.seed = s.seed;
  return core;
}

unsigned thread_count(guint n_threads) {
  if (n_threads > 0) return n_threads;
  return std::max(2u, std::thread::hardware_concurrency()) - 1;
}

}  // namespace csd
