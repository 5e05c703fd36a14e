// SPDX-License-Identifier: LGPL-2.1-or-later
#include "support/track_properties.h"

#include "overlay/overlay.h"
#include "support/presets.h"
#include "support/value_arrays.h"

namespace csd {
namespace {

constexpr auto common = static_cast<GParamFlags>(G_PARAM_READWRITE | G_PARAM_STATIC_STRINGS);
constexpr auto structural = static_cast<GParamFlags>(common | GST_PARAM_MUTABLE_READY);
constexpr auto live = static_cast<GParamFlags>(common | GST_PARAM_MUTABLE_PLAYING | GST_PARAM_CONTROLLABLE);
constexpr auto longest = static_cast<GstClockTime>(G_MAXINT64);  // the core's times are signed

using S = ElementSettings;
using L = LiveSettings;

template <auto... Path>
Property<S> of(GParamSpec *spec) {
  return member_property<S, Path...>(spec);
}

/// A text that a preset may have saved.
template <std::string S::*text>
Property<S> text_of_preset(GParamSpec *spec) {
  return {.spec = spec,
          .get = [](const S &s, GValue *value) { to_value(value, s.*text); },
          .set = [](S &s, const GValue *value) { s.*text = preset_text(g_value_get_string(value)); }};
}

/// The same setting as another, as an array. The text is what is kept.
template <std::string S::*text, auto to_text, auto from_text>
Property<S> array_of(GParamSpec *spec) {
  return {.spec = spec,
          .get = [](const S &s, GValue *value) { from_text(*value, s.*text); },
          .set = [](S &s, const GValue *value) { s.*text = to_text(*value); }};
}

}  // namespace

std::vector<Property<S>> track_properties(void (*overlay_changed)(gpointer), void (*stats)(gpointer, GValue *)) {
  const S d;
  Property<S> overlay = of<&S::live, &L::overlay>(Overlay::param_spec());
  overlay.changed = overlay_changed;
  return {
      /**
       * GstCsdTrack:algorithm:
       *
       * Since: 0.1
       */
      of<&S::algorithm>(g_param_spec_enum(
          "algorithm", "Algorithm",
          "How features are tracked. csd: this project's own way, the one to use. csd-2012: the paper's. "
          "csd-forest: the same with several trees for each feature, at several times the time and memory; "
          "what is said of csd-2012 applies. The others are for comparison",
          GST_TYPE_CSD_TRACK_ALGORITHM, d.algorithm, structural)),
      /**
       * GstCsdTrack:max-features:
       *
       * Since: 0.1
       */
      of<&S::max_features>(g_param_spec_uint(
          "max-features", "Maximum features",
          "Detected features to maintain, besides given points. 0: no detection. csd starts none on grey "
          "areas in coloured tissue, such as most instruments",
          0, static_cast<guint>(max_points), d.max_features, structural)),
      /**
       * GstCsdTrack:points:
       *
       * Since: 0.1
       */
      text_of_preset<&S::points>(g_param_spec_string(
          "points", "Points",
          "Points to track instead of detected features: x,y;x,y;... in pixels of the picture, centres at "
          "integers, with a decimal point, at most 10000, with the ids 0, 1, 2... in that order. truth: the"
          " points that csdsimsrc reports as visible, under its ids. Empty: detection. Checked on the way "
          "to READY, or to PAUSED if set later",
          d.points.c_str(), structural)),
      /**
       * GstCsdTrack:points-array:
       *
       * Since: 0.1
       */
      array_of<&S::points, points_text, set_points>(gst_param_spec_array(
          "points-array", "Points as an array",
          "The same as points, for programs: <<x,y>,<x,y>>. The one set last counts", nullptr, structural)),
      /**
       * GstCsdTrack:replenish:
       *
       * Since: 0.1
       */
      of<&S::replenish>(g_param_spec_boolean(
          "replenish", "Replenish",
          "Replaces ended features by new ones, with new ids, at most twice a second. csd only: other "
          "algorithms stop detection two seconds after their first feature",
          d.replenish, structural)),
      /**
       * GstCsdTrack:forget-after:
       *
       * Since: 0.1
       */
      of<&S::forget_after>(g_param_spec_uint64(
          "forget-after", "Forget after",
          "Drops detected features that stay lost or out for this many nanoseconds; they are reported once "
          "as ended. 0: never",
          0, longest, d.forget_after, structural)),
      /**
       * GstCsdTrack:region:
       *
       * Since: 0.1
       */
      text_of_preset<&S::region>(g_param_spec_string(
          "region", "Region",
          "Where features are detected: x,y,w,h in whole pixels of the picture, each 0 to 32768, w and h "
          "from 1. Empty: everywhere. Features may leave it. Checked on the way to READY, or to PAUSED if "
          "set later",
          d.region.c_str(), structural)),
      /**
       * GstCsdTrack:region-array:
       *
       * Since: 0.1
       */
      array_of<&S::region, region_text, set_region>(gst_param_spec_array(
          "region-array", "Region as an array", "The same as region, for programs: <x,y,w,h>. The one set last counts",
          nullptr, structural)),
      /**
       * GstCsdTrack:content-area:
       *
       * Since: 0.1
       */
      of<&S::content_area>(g_param_spec_enum(
          "content-area", "Content area",
          "Which part of the picture is tissue. auto: detection and learning avoid the dark border and "
          "burnt-in graphics, and detected features on them end. full: all of it",
          GST_TYPE_CSD_TRACK_CONTENT_AREA, d.content_area, structural)),
      /**
       * GstCsdTrack:patch-size:
       *
       * Since: 0.1
       */
      of<&S::patch_size>(g_param_spec_uint(
          "patch-size", "Patch size",
          "Side of a feature's patch, in pixels of the full picture. 0: 21 for 480 to 576 lines, 4.4 % of "
          "the height below (at least 9), 3.6 % above. Rounded to an odd number of working pixels, 5 to "
          "255. csd also uses twice and four times the size",
          0, 1024, d.patch_size, structural)),
      /**
       * GstCsdTrack:search-radius:
       *
       * Since: 0.1
       */
      of<&S::search_radius>(g_param_spec_uint(
          "search-radius", "Search radius",
          "How far from its last position a feature is searched for, in pixels of the full picture; up to "
          "twice that while hidden. 0: 20 for 480 to 576 lines, else in proportion to the patch. The cost "
          "grows with its square. csd-2012 only",
          0, 2048, d.search_radius, structural)),
      /**
       * GstCsdTrack:training-time:
       *
       * Since: 0.1
       */
      of<&S::training_time>(g_param_spec_uint64(
          "training-time", "Training time",
          "csd: for how many nanoseconds a feature's appearance is sampled; 0: in its first frame alone. "
          "csd-2012: how long Lucas-Kanade tracks a feature while its descriptor is learnt, for at least 8 "
          "frames, and until the descriptor is ready",
          0, longest, d.training_time, structural)),
      /**
       * GstCsdTrack:learning:
       *
       * Since: 0.1
       */
      of<&S::learning>(g_param_spec_enum(
          "learning", "Learning",
          "Whether a frame waits for the learning that it causes. async: never. sync, for files: always; "
          "results are then the same on each run and for each n-threads, as csd's always are without frame-"
          "budget. csd-2012 only: csd learns within the frame",
          GST_TYPE_CSD_TRACK_LEARNING, d.learning, structural)),
      /**
       * GstCsdTrack:n-threads:
       *
       * Since: 0.1
       */
      of<&S::n_threads>(g_param_spec_uint(
          "n-threads", "Threads",
          "Worker threads, below normal priority, in which csd tracks and csd-2012 learns. 0: one fewer "
          "than the processors, at least 1",
          0, 256, d.n_threads, structural)),
      /**
       * GstCsdTrack:frame-budget:
       *
       * Since: 0.1
       */
      of<&S::frame_budget>(
          g_param_spec_uint64("frame-budget", "Frame budget",
                              "After this many nanoseconds in a frame the least urgent features wait for a later one "
                              "(fresh=false). 0: none waits. csd only",
                              0, longest, d.frame_budget, structural)),
      /**
       * GstCsdTrack:seed:
       *
       * Since: 0.1
       */
      of<&S::seed>(g_param_spec_uint64("seed", "Seed",
                                       "Seeds each random choice in learning. csd-2012 only: csd makes none", 0,
                                       G_MAXUINT64, d.seed, structural)),
      /**
       * GstCsdTrack:overlay:
       *
       * Since: 0.1
       */
      overlay,
      /**
       * GstCsdTrack:attach-meta:
       *
       * Since: 0.1
       */
      of<&S::live, &L::attach_meta>(
          g_param_spec_boolean("attach-meta", "Attach meta",
                               "Attaches a GstCsdTrackMeta with all features to each frame. csdtrackenc needs it",
                               d.live.attach_meta, live)),
      /**
       * GstCsdTrack:attach-roi:
       *
       * Since: 0.1
       */
      of<&S::live, &L::attach_roi>(g_param_spec_boolean(
          "attach-roi", "Attach ROI",
          "Also attaches a GstVideoRegionOfInterestMeta of type csdtrack for each learning or tracked "
          "feature: a square of the patch's size, in pixels of the whole frame, clipped to it; its id is "
          "the feature's",
          d.live.attach_roi, live)),
#ifdef CSDTRACK_ANALYTICS
      /**
       * GstCsdTrack:attach-analytics:
       *
       * Since: 0.1
       */
      of<&S::live, &L::attach_analytics>(g_param_spec_boolean(
          "attach-analytics", "Attach analytics",
          "Also attaches GstAnalytics metadata: a tracking for each feature, related to a detection of type"
          " csdtrack while the feature is seen (GStreamer 1.30: and to a key point)",
          d.live.attach_analytics, live)),
#endif
      /**
       * GstCsdTrack:post-messages:
       *
       * Since: 0.1
       */
      of<&S::live, &L::post_messages>(g_param_spec_enum(
          "post-messages", "Post messages",
          "When an element message csdtrack with all features is posted. change: when a feature is new or "
          "changes its state. frame: for each frame. Set none if nobody reads the bus",
          GST_TYPE_CSD_TRACK_POST_MESSAGES, d.live.post_messages, live)),
      /**
       * GstCsdTrack:message-interval:
       *
       * Since: 0.1
       */
      of<&S::live, &L::message_interval>(g_param_spec_uint64(
          "message-interval", "Message interval",
          "Least running time between two messages, in nanoseconds. A change in between is posted at the "
          "end of the interval or of the stream. 0: no limit",
          0, longest, d.live.message_interval, live)),
      /**
       * GstCsdTrack:on-error:
       *
       * Since: 0.1
       */
      of<&S::live, &L::on_error>(g_param_spec_enum(
          "on-error", "On error",
          "What happens when a frame can't be tracked. error: the stream stops with a message. pass, for "
          "recorders: one WARNING from READY to READY; frames pass untouched, with features lost",
          GST_TYPE_CSD_TRACK_ON_ERROR, d.live.on_error, live)),
      /**
       * GstCsdTrack:navigation:
       *
       * Since: 0.1
       */
      of<&S::live, &L::navigation>(g_param_spec_boolean(
          "navigation", "Navigation",
          "In the window of ximagesink, xvimagesink, glimagesink and others a click or a finger adds a "
          "point, a click with the third (right) button removes the nearest feature, and the key r emits reset",
          d.live.navigation, live)),
      /**
       * GstCsdTrack:stats:
       *
       * Since: 0.1
       */
      {.spec = g_param_spec_boxed("stats", "Statistics", "Statistics since READY", GST_TYPE_STRUCTURE,
                                  static_cast<GParamFlags>(G_PARAM_READABLE | G_PARAM_STATIC_STRINGS)),
       .compute = stats},
  };
}

}  // namespace csd
