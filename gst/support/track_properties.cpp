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
       * How features are tracked. `csd`, the project's own method, is the one to use; the others are for comparison.
       *
       * Since: 0.1
       */
      of<&S::algorithm>(g_param_spec_enum(
          "algorithm", "Algorithm", "How features are tracked; csd is the one to use, the others are for comparison",
          GST_TYPE_CSD_TRACK_ALGORITHM, d.algorithm, structural)),
      /**
       * GstCsdTrack:max-features:
       *
       * The maximum number of detected features. Given points don't count. 0: no detection.
       *
       * Since: 0.1
       */
      of<&S::max_features>(
          g_param_spec_uint("max-features", "Maximum features",
                            "Maximum number of detected features; 0 = no detection. Given points don't count", 0,
                            static_cast<guint>(max_points), d.max_features, structural)),
      /**
       * GstCsdTrack:points:
       *
       * Points to track instead of detected features: `x,y;x,y;…` in pixels of the picture, centres at integers, with
       * the ids 0, 1, 2… in that order; or `truth` for the points that csdsimsrc reports as visible, under its ids.
       * Text that can't be parsed is an error on the way to READY, or to PAUSED if set later.
       *
       * Since: 0.1
       */
      text_of_preset<&S::points>(g_param_spec_string(
          "points", "Points",
          "Track these points instead of detected features: \"x,y;x,y;...\" in pixels of the picture, centres at "
          "integers, with a decimal point; ids 0,1,2... in that order; at most 10000. \"truth\" = the points that "
          "csdsimsrc reports as visible, under its ids. Empty = detect. Checked on the way to READY and PAUSED",
          d.points.c_str(), structural)),
      /**
       * GstCsdTrack:points-array:
       *
       * The same setting as #GstCsdTrack:points, as an array of arrays of two numbers, for programs. Whichever of the
       * two is set last counts.
       *
       * Since: 0.1
       */
      array_of<&S::points, points_text, set_points>(gst_param_spec_array(
          "points-array", "Points as an array",
          "The points as an array of <x,y>: the same setting as points, for programs", nullptr, structural)),
      /**
       * GstCsdTrack:replenish:
       *
       * Whether new features, with new ids, replace ended ones. Only `csd` supports it.
       *
       * Since: 0.1
       */
      of<&S::replenish>(g_param_spec_boolean("replenish", "Replenish",
                                             "Detect new features, with new ids, as old ones end (csd only)",
                                             d.replenish, structural)),
      /**
       * GstCsdTrack:forget-after:
       *
       * Ends detected features that stay lost or out for this long: they are reported once as ended and then dropped.
       * 0: never. Doesn't apply to given points.
       *
       * Since: 0.1
       */
      of<&S::forget_after>(
          g_param_spec_uint64("forget-after", "Forget after",
                              "Drop detected features that stay lost or out for this many nanoseconds; they are "
                              "reported once as ended. 0 = never. Doesn't apply to given points",
                              0, longest, d.forget_after, structural)),
      /**
       * GstCsdTrack:region:
       *
       * Where to detect features: `x,y,w,h` in whole pixels of the picture. Features may leave it later. Empty:
       * everywhere.
       *
       * Since: 0.1
       */
      text_of_preset<&S::region>(
          g_param_spec_string("region", "Region",
                              "Where to detect features: \"x,y,w,h\" in whole pixels of the picture. "
                              "Empty = everywhere. Checked on the way to READY and PAUSED",
                              d.region.c_str(), structural)),
      /**
       * GstCsdTrack:region-array:
       *
       * The same setting as #GstCsdTrack:region, as an array of four numbers, for programs. Whichever of the two is set
       * last counts.
       *
       * Since: 0.1
       */
      array_of<&S::region, region_text, set_region>(gst_param_spec_array(
          "region-array", "Region as an array",
          "The region as <x,y,width,height>: the same setting as region, for programs", nullptr, structural)),
      /**
       * GstCsdTrack:content-area:
       *
       * Whether detection and learning exclude the dark border of an endoscope's picture and burnt-in graphics, which
       * the element then finds by itself.
       *
       * Since: 0.1
       */
      of<&S::content_area>(g_param_spec_enum(
          "content-area", "Content area", "Which part of the picture is tissue: detection and learning stay inside it",
          GST_TYPE_CSD_TRACK_CONTENT_AREA, d.content_area, structural)),
      /**
       * GstCsdTrack:patch-size:
       *
       * Side of the square patch of a feature, in pixels of the full picture. 0: depends on the picture's height.
       *
       * Since: 0.1
       */
      of<&S::patch_size>(g_param_spec_uint("patch-size", "Patch size",
                                           "Side of a feature's patch in pixels of the full picture; 0 = depends on "
                                           "the picture's height (21 at 480 lines)",
                                           0, 1024, d.patch_size, structural)),
      /**
       * GstCsdTrack:search-radius:
       *
       * How far to search around a feature's last position, in pixels of the full picture. 0: depends on the picture's
       * height. Only for `csd-2012` and `csd-forest`.
       *
       * Since: 0.1
       */
      of<&S::search_radius>(
          g_param_spec_uint("search-radius", "Search radius",
                            "How far to search around a feature's last position, in pixels of the full picture; 0 = "
                            "depends on the picture's height (20 at 480 lines). csd-2012 and csd-forest only",
                            0, 2048, d.search_radius, structural)),
      /**
       * GstCsdTrack:training-time:
       *
       * How long a feature stays in state learning. `csd` collects its anchor meanwhile; `csd-2012` and `csd-forest`
       * track it with Lucas-Kanade until their descriptor is ready.
       *
       * Since: 0.1
       */
      of<&S::training_time>(g_param_spec_uint64(
          "training-time", "Training time",
          "How many nanoseconds a feature stays in state learning. csd collects its anchor meanwhile; csd-2012 and "
          "csd-forest use Lucas-Kanade, for at least 8 frames, until their descriptor is ready",
          0, longest, d.training_time, structural)),
      /**
       * GstCsdTrack:learning:
       *
       * Whether a frame waits for the learning that it triggers. With `sync` and no frame-budget the results are the
       * same on every run and for any number of threads; live video needs `async`.
       *
       * Since: 0.1
       */
      of<&S::learning>(g_param_spec_enum("learning", "Learning",
                                         "Whether a frame waits for the learning that it triggers (csd-2012 and "
                                         "csd-forest only: csd learns within the frame)",
                                         GST_TYPE_CSD_TRACK_LEARNING, d.learning, structural)),
      /**
       * GstCsdTrack:n-threads:
       *
       * Number of threads for this element, below normal priority. 0: one fewer than the number of processors, at
       * least 1.
       *
       * Since: 0.1
       */
      of<&S::n_threads>(g_param_spec_uint(
          "n-threads", "Threads",
          "Number of threads of this element, below normal priority: csd tracks in them while they are idle, "
          "csd-2012 and csd-forest learn in them. 0 = one fewer than the number of processors, at least 1",
          0, 256, d.n_threads, structural)),
      /**
       * GstCsdTrack:frame-budget:
       *
       * After this many nanoseconds in a frame the least urgent features wait for the next one, and are not `fresh`.
       * The frame itself never waits. 0: no limit.
       *
       * Since: 0.1
       */
      of<&S::frame_budget>(g_param_spec_uint64("frame-budget", "Frame budget",
                                               "After this many nanoseconds in a frame the least urgent features "
                                               "wait for the next one (fresh=false). 0 = no limit. csd only",
                                               0, longest, d.frame_budget, structural)),
      /**
       * GstCsdTrack:seed:
       *
       * Seeds every random choice in learning.
       *
       * Since: 0.1
       */
      of<&S::seed>(g_param_spec_uint64(
          "seed", "Seed", "Seeds every random choice in learning (csd-2012 and csd-forest only: csd makes none)", 0,
          G_MAXUINT64, d.seed, structural)),
      /**
       * GstCsdTrack:overlay:
       *
       * How features are shown: drawn into the pixels, or as a #GstVideoOverlayComposition beside them. If downstream
       * can't show the latter, the element posts one WARNING and leaves the pixels as they are.
       *
       * Since: 0.1
       */
      overlay,
      /**
       * GstCsdTrack:attach-meta:
       *
       * Whether to attach a `GstCsdTrackMeta` with all features to each frame.
       *
       * Since: 0.1
       */
      of<&S::live, &L::attach_meta>(g_param_spec_boolean("attach-meta", "Attach meta",
                                                         "Attach a GstCsdTrackMeta with all features to each frame",
                                                         d.live.attach_meta, live)),
      /**
       * GstCsdTrack:attach-roi:
       *
       * Whether to also attach a #GstVideoRegionOfInterestMeta to each frame for every feature that claims a position,
       * for elements that only know that.
       *
       * Since: 0.1
       */
      of<&S::live, &L::attach_roi>(
          g_param_spec_boolean("attach-roi", "Attach ROI",
                               "Also attach a GstVideoRegionOfInterestMeta of type csdtrack, the size of its patch, "
                               "for each feature that claims a position; for elements that only know that meta",
                               d.live.attach_roi, live)),
#ifdef CSDTRACK_ANALYTICS
      /**
       * GstCsdTrack:attach-analytics:
       *
       * Whether to also attach GstAnalytics metadata to each frame: a tracking per feature, related to a detection
       * while the feature is seen, and with GStreamer 1.30 to a key point. Only if the plugin was built with
       * gstreamer-analytics, 1.24 or later.
       *
       * Since: 0.1
       */
      of<&S::live, &L::attach_analytics>(
          g_param_spec_boolean("attach-analytics", "Attach analytics",
                               "Also attach GstAnalytics metadata: a tracking for each feature, related to a detection "
                               "of type csdtrack while the feature is seen (GStreamer 1.30: and to a key point)",
                               d.live.attach_analytics, live)),
#endif
      /**
       * GstCsdTrack:post-messages:
       *
       * When to post an element message `csdtrack` with all features.
       *
       * Since: 0.1
       */
      of<&S::live, &L::post_messages>(g_param_spec_enum("post-messages", "Post messages",
                                                        "When to post an element message csdtrack with all features",
                                                        GST_TYPE_CSD_TRACK_POST_MESSAGES, d.live.post_messages, live)),
      /**
       * GstCsdTrack:message-interval:
       *
       * Minimum running time between two messages. A change in between is posted at the end of the interval or of the
       * stream.
       *
       * Since: 0.1
       */
      of<&S::live, &L::message_interval>(
          g_param_spec_uint64("message-interval", "Message interval",
                              "Minimum running time between two messages, in nanoseconds; a change in between is "
                              "posted at the end of the interval or of the stream. 0 = no limit",
                              0, longest, d.live.message_interval, live)),
      /**
       * GstCsdTrack:on-error:
       *
       * What to do with a frame that can't be tracked: post an error, or pass it on unchanged, with one WARNING from
       * READY to READY.
       *
       * Since: 0.1
       */
      of<&S::live, &L::on_error>(g_param_spec_enum("on-error", "On error", "What to do when a frame can't be tracked",
                                                   GST_TYPE_CSD_TRACK_ON_ERROR, d.live.on_error, live)),
      /**
       * GstCsdTrack:navigation:
       *
       * Whether input in a video sink's window adds and removes points: a click or a finger adds one, a click with the
       * third button removes the nearest feature, the key r resets.
       *
       * Since: 0.1
       */
      of<&S::live, &L::navigation>(
          g_param_spec_boolean("navigation", "Navigation",
                               "Take input from a video sink's window: a click or a finger adds a point, a click "
                               "with the third button removes the nearest feature, the key r resets",
                               d.live.navigation, live)),
      /**
       * GstCsdTrack:stats:
       *
       * Statistics since READY: counts of frames and features, times per frame, learning. docs/elements.md lists the
       * fields.
       *
       * Since: 0.1
       */
      {.spec = g_param_spec_boxed(
           "stats", "Statistics",
           "Since READY: frames, failed-frames, the number of features in each state, detected (features started so "
           "far), time-p50, time-p95, time-max (ns per frame), learning-time (ns, all jobs together), learned, "
           "retrainings, false-correspondences, queue (learning jobs that wait), waited, simd",
           GST_TYPE_STRUCTURE, static_cast<GParamFlags>(G_PARAM_READABLE | G_PARAM_STATIC_STRINGS)),
       .compute = stats},
  };
}

}  // namespace csd
