// SPDX-License-Identifier: LGPL-2.1-or-later
#include "settings.h"

#include <algorithm>
#include <thread>
#include <type_traits>

#include "overlay.h"
#include "text/parse.h"

namespace csd {
namespace {

constexpr auto common = static_cast<GParamFlags>(G_PARAM_READWRITE | G_PARAM_STATIC_STRINGS);
constexpr auto structural = static_cast<GParamFlags>(common | GST_PARAM_MUTABLE_READY);
constexpr auto live = static_cast<GParamFlags>(common | GST_PARAM_MUTABLE_PLAYING | GST_PARAM_CONTROLLABLE);
constexpr auto longest = static_cast<GstClockTime>(G_MAXINT64);  // the core's times are signed

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

const char *or_empty(const gchar *text) {
  return text ? text : "";
}

}  // namespace

void install_properties(GObjectClass *klass) {
  const ElementSettings d;
  const auto install = [klass](Property id, GParamSpec *spec) { g_object_class_install_property(klass, id, spec); };

  install(prop_algorithm, g_param_spec_enum("algorithm", "Algorithm", "How features are followed",
                                            GST_TYPE_CSD_TRACK_ALGORITHM, d.algorithm, structural));
  install(prop_max_features,
          g_param_spec_uint("max-features", "Maximum features",
                            "How many features detection keeps; 0 = none, only points that are given. Points that are "
                            "given don't count",
                            0, static_cast<guint>(max_points), d.max_features, structural));
  install(prop_points,
          g_param_spec_string("points", "Points",
                              "\"x,y;x,y;...\" in pixels of the picture, centres at integers, decimal point: track "
                              "exactly these, with ids 0,1,2... in that order, without detection; at most 10000. "
                              "\"truth\" = what csdsimsrc says is visible, under its ids. Empty = detect. Checked when "
                              "the element goes to READY and PAUSED",
                              d.points.c_str(), structural));
  install(prop_replenish,
          g_param_spec_boolean("replenish", "Replenish",
                               "Detect new features, with new ids, as old ones end (only csd does, the others never)",
                               d.replenish, structural));
  install(prop_forget_after,
          g_param_spec_uint64("forget-after", "Forget after",
                              "A detected feature that is lost or out for this many nanoseconds ends: it is reported "
                              "once as ended and leaves the list; 0 = never. Points that were given never end",
                              0, longest, d.forget_after, structural));
  install(prop_region, g_param_spec_string(
                           "region", "Region",
                           "\"x,y,w,h\" in whole pixels of the picture: where detection may look. Empty = everywhere. "
                           "Checked when the element goes to READY and PAUSED",
                           d.region.c_str(), structural));
  install(prop_content_area, g_param_spec_enum("content-area", "Content area",
                                               "What of the picture is tissue, where detection and learning may look",
                                               GST_TYPE_CSD_TRACK_CONTENT_AREA, d.content_area, structural));
  install(prop_patch_size, g_param_spec_uint("patch-size", "Patch size",
                                             "Side of a feature's patch in pixels of the full picture; 0 = from the "
                                             "picture's height (21 at 480 lines)",
                                             0, 1024, d.patch_size, structural));
  install(prop_search_radius,
          g_param_spec_uint("search-radius", "Search radius",
                            "How far a feature is looked for from where it was, in pixels of the full picture; 0 = "
                            "from the picture's height (20 at 480 lines; only csd-2012 and csd-forest use it)",
                            0, 2048, d.search_radius, structural));
  install(prop_training_time,
          g_param_spec_uint64(
              "training-time", "Training time",
              "How many nanoseconds a feature is in state learning. csd: while its anchor is gathered; "
              "csd-2012, csd-forest: at least 8 frames, followed by Lucas-Kanade, before descriptors take over",
              0, longest, d.training_time, structural));
  install(prop_learning, g_param_spec_enum("learning", "Learning",
                                           "Whether frames wait for the learning that they cause (of csd-2012 and "
                                           "csd-forest: csd learns in the frame itself)",
                                           GST_TYPE_CSD_TRACK_LEARNING, d.learning, structural));
  install(prop_n_threads,
          g_param_spec_uint(
              "n-threads", "Threads",
              "Threads of this element, below normal priority: csd follows points in them while they are "
              "idle, csd-2012 and csd-forest learn in them; 0 = one fewer than the machine has processors, at least 1",
              0, 256, d.n_threads, structural));
  install(prop_frame_budget,
          g_param_spec_uint64("frame-budget", "Frame budget",
                              "Past so many nanoseconds of a frame the features that are least urgent wait for the "
                              "next one (fresh=false); 0 = none waits (only csd does)",
                              0, longest, d.frame_budget, structural));
  install(prop_seed,
          g_param_spec_uint64("seed", "Seed",
                              "Of every random choice that learning makes (of csd-2012 and csd-forest: csd makes none)",
                              0, G_MAXUINT64, d.seed, structural));

  install(prop_overlay, Overlay::param_spec());
  install(prop_attach_meta,
          g_param_spec_boolean("attach-meta", "Attach meta", "Attach a GstCsdTrackMeta with all features to each frame",
                               d.live.attach_meta, live));
  install(prop_attach_roi,
          g_param_spec_boolean("attach-roi", "Attach ROI",
                               "Attach also one GstVideoRegionOfInterestMeta of type csdtrack for each feature that is "
                               "seen, the size of its patch, for elements that know only that",
                               d.live.attach_roi, live));
#ifdef CSDTRACK_ANALYTICS
  install(prop_attach_analytics,
          g_param_spec_boolean("attach-analytics", "Attach analytics",
                               "Attach also GstAnalytics metadata: a tracking for each feature, related to a detection "
                               "of type csdtrack where it is seen (GStreamer 1.30: and to a key point)",
                               d.live.attach_analytics, live));
#endif
  install(prop_post_messages, g_param_spec_enum("post-messages", "Post messages",
                                                "When to post an element message csdtrack with all features",
                                                GST_TYPE_CSD_TRACK_POST_MESSAGES, d.live.post_messages, live));
  install(prop_message_interval,
          g_param_spec_uint64("message-interval", "Message interval",
                              "At least so many nanoseconds of running time between two messages; a change in between "
                              "is posted when they have passed or the stream ends; 0 = no limit",
                              0, longest, d.live.message_interval, live));
  install(prop_on_error, g_param_spec_enum("on-error", "On error", "What to do when a frame can't be tracked",
                                           GST_TYPE_CSD_TRACK_ON_ERROR, d.live.on_error, live));
  install(prop_navigation,
          g_param_spec_boolean("navigation", "Navigation",
                               "In a video sink's window a click adds a point, a click with the third button removes "
                               "the nearest feature, the key r resets",
                               d.live.navigation, live));
  install(prop_stats, g_param_spec_boxed(
                          "stats", "Statistics",
                          "Since READY: frames, failed-frames, features now by state, detected (features that ever "
                          "began), time-p50, time-p95, time-max (ns per frame), learning-time (ns that learning jobs "
                          "took, added up), learned, retrainings, false-correspondences, queue (learning jobs that "
                          "wait), waited, simd",
                          GST_TYPE_STRUCTURE, static_cast<GParamFlags>(G_PARAM_READABLE | G_PARAM_STATIC_STRINGS)));
}

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
      s.points = or_empty(g_value_get_string(&value));
      return true;
    case prop_replenish:
      s.replenish = g_value_get_boolean(&value);
      return true;
    case prop_forget_after:
      s.forget_after = g_value_get_uint64(&value);
      return true;
    case prop_region:
      s.region = or_empty(g_value_get_string(&value));
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
    case prop_replenish:
      g_value_set_boolean(&value, s.replenish);
      return true;
    case prop_forget_after:
      g_value_set_uint64(&value, s.forget_after);
      return true;
    case prop_region:
      g_value_set_string(&value, s.region.c_str());
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
