// SPDX-License-Identifier: LGPL-2.1-or-later
/**
 * SECTION:element-csdtrack
 * @title: csdtrack
 * @short_description: tracks points on deforming tissue
 *
 * Detects features on living tissue in endoscopic video, or takes given points, and follows them from frame to frame
 * through deformation, smoke and occlusion. It searches for each feature by its own patch and by the motion of the
 * tissue around it, and weights the two by how distinctive the patch is. #GstCsdTrack:algorithm also offers the method
 * this element grew out of (Mountney and Yang, "Context specific descriptors for tracking deforming tissue", Medical
 * Image Analysis 16, 2012), and its baselines.
 *
 * The element reads pixels without copying or changing them, and never drops or delays a frame; only
 * #GstCsdTrack:overlay=draw changes pixels. It attaches the tracks to each frame as a #GstCustomMeta named
 * `GstCsdTrackMeta`, and can post them on the bus and draw them; csdtrackenc writes them to a file.
 *
 * ## Example launch lines
 *
 * |[
 * gst-launch-1.0 filesrc location=operation.mp4 ! decodebin ! csdtrack overlay=draw ! videoconvert ! autovideosink
 * ]| Shows the tracks.
 * |[
 * gst-launch-1.0 -m filesrc location=operation.mp4 ! decodebin ! csdtrack points="320,240;100.5,80" ! fakesink
 * ]| Follows two points and prints the messages.
 * |[
 * gst-launch-1.0 filesrc location=operation.mp4 ! decodebin ! csdtrack ! tee name=t \
 *   t. ! queue ! x264enc ! mp4mux ! filesink location=copy.mp4 \
 *   t. ! csdtrackenc ! queue max-size-time=5000000000 max-size-buffers=0 max-size-bytes=0 \
 *   ! filesink location=tracks.jsonl buffer-mode=unbuffered
 * ]| Records the unmodified video and its tracks beside it. The second queue must hold what the encoder holds back.
 *
 * ## The message
 *
 * With #GstCsdTrack:post-messages the element posts an element message named `csdtrack`, with these fields:
 *
 * * #GstClockTime `timestamp`, `stream-time`, `running-time`, `duration`: of the frame; GST_CLOCK_TIME_NONE if unknown.
 * * #gint `schema`: 1.
 * * #gchararray `source`: the name of this element; `algorithm`: the nick of #GstCsdTrack:algorithm.
 * * #guint64 `frame`: buffers since READY, from 0.
 * * #gint `width`, `height`: the picture that the positions refer to; `tracked-width`, `tracked-height`: the picture
 *   that was tracked. They are equal in a message; in a meta, `width` and `height` are scaled along with the frame.
 * * #GST_TYPE_ARRAY `features`: structures with #guint `id`, #gdouble `x`, `y` (pixels, centres at integers, top left
 *   0,0; always finite), #gchararray `state`, #gdouble `confidence` (0 to 1), #gboolean `fresh`.
 *
 * A feature's state is `learning` or `tracked` (these two claim a position), `occluded` (hidden for less than 1 s, or
 * for any time in csdsimsrc's truth; the position is a prediction), `lost`, `out` (left the picture) or `ended`
 * (reported once). For the last three the position is the last one claimed. Ids are not reused before the element goes
 * to READY.
 *
 * The meta holds the same fields without the four times.
 *
 * ## Regions of interest
 *
 * With #GstCsdTrack:attach-roi each feature in state `learning` or `tracked` also gets a #GstVideoRegionOfInterestMeta:
 * type `csdtrack`, the feature's `id`, a square of the patch's size around it, clipped to the frame (in pixels of the
 * whole frame, even with a #GstVideoCropMeta), and one parameter structure `csdtrack` with #guint `id`, #gdouble `x`,
 * `y`, #gchararray `state`, #gdouble `confidence` as above. GStreamer drops the parameters of these metas when it
 * converts a frame, so rely on the #GstCustomMeta.
 *
 * ## GstAnalytics
 *
 * If built with gstreamer-analytics (1.24 or later), `attach-analytics` adds a tracking with the feature's id to the
 * frame's relation meta for each feature. While the feature claims a position, the tracking relates to a detection of
 * type `csdtrack`, the same square. With 1.30 it also relates to a key point, at the claimed or predicted position.
 *
 * ## When the stream is forgotten
 *
 * These end all features and start new ones under new ids: FLUSH_STOP, STREAM_START with another stream-id, a change of
 * width, height or interlacing in the caps, and the signal #GstCsdTrack::reset. READY also resets the ids.
 *
 * Since: 0.1
 */
#include "elements/csdtrack.h"

#include <chrono>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>

#include "caps/frame_mapping.h"
#include "caps/frame_time.h"
#include "meta/message.h"
#include "meta/meta.h"
#include "meta/rois.h"
#include "overlay/overlay.h"
#include "support/guard.h"
#include "support/latency.h"
#include "support/lock.h"
#include "support/navigation.h"
#include "support/presets.h"
#include "support/property_table.h"
#ifdef CSDTRACK_ANALYTICS
#include "meta/analytics.h"
#endif
#include "algorithms/make_algorithm.h"
#include "support/settings.h"
#include "support/stats.h"
#include "track/thread_pool.h"
#include "track/tracker.h"

GST_DEBUG_CATEGORY_STATIC(gst_csd_track_debug);
#define GST_CAT_DEFAULT gst_csd_track_debug

namespace {

// Learners yield to the streaming threads and to encoders. 10 is the default of nice(1).
constexpr int learner_nice = 10;

enum Signal : guint { signal_add_point, signal_remove_point, signal_reset, signal_count };
guint gst_csd_track_signals[signal_count];

/// A tracker and its learner threads, created at READY→PAUSED. A signal may hold a reference for the length of a call.
struct Engine {
  Engine(const csd::Settings &settings, unsigned threads)
      : pool(threads, learner_nice), tracker(settings, csd::make_algorithm(settings, pool)) {}

  csd::ThreadPool pool;  // must outlive the tracker
  csd::Tracker tracker;
};

/// State of the streaming thread, from READY to READY.
struct Stream {
  std::uint64_t frame = 0;    ///< number of the next buffer
  std::string id;             ///< from the last STREAM_START
  int width = 0, height = 0;  ///< last picture (the rectangle, with a crop)
  csd::TrackMessages messages;
#ifdef CSDTRACK_ANALYTICS
  csd::Analytics analytics;
#endif
  bool warned_failure = false, warned_small = false;
};

}  // namespace

/// The C++ members, with destructors.
struct GstCsdTrackState {
  explicit GstCsdTrackState(GstBaseTransform *element)
      : overlay(GST_ELEMENT(element), element->sinkpad, element->srcpad) {}

  // Guarded by the object lock, held only for a copy.
  csd::ElementSettings settings;
  bool running = false;            ///< since READY→PAUSED: then some settings are read-only
  std::shared_ptr<Engine> engine;  ///< set by start() and stop() only, so the streaming thread reads it unlocked
  csd::Stats last_stats;           ///< of the previous engine, for reads after the stop
  csd::Latency latency;
  guint64 failed_frames = 0;

  csd::Overlay overlay;  ///< documents which thread may call what
  csd::Navigation navigation;

  // Streaming thread only. start() resets it.
  Stream stream;
  csd::AlgorithmKind algorithm = csd::AlgorithmKind::csd;
  unsigned patch_size = 0;
  bool points_from_truth = false;
};

struct _GstCsdTrack {
  GstVideoFilter parent;
  GstCsdTrackState *state;
};

G_DEFINE_TYPE_WITH_CODE(GstCsdTrack, gst_csd_track, GST_TYPE_VIDEO_FILTER,
                        G_IMPLEMENT_INTERFACE(GST_TYPE_PRESET, csd::init_preset);
                        GST_DEBUG_CATEGORY_INIT(gst_csd_track_debug, "csdtrack", 0, "tissue tracker"))
GST_ELEMENT_REGISTER_DEFINE_WITH_CODE(csdtrack, "csdtrack", GST_RANK_NONE, GST_TYPE_CSD_TRACK,
                                      csd::register_track_metas())

namespace {

std::shared_ptr<Engine> engine_of(GstCsdTrack *self) {
  const csd::ObjectLock lock(self);
  return self->state->engine;
}

csd::LiveSettings live_settings(GstCsdTrack *self) {
  const csd::ObjectLock lock(self);
  return self->state->settings.live;
}

using Properties = csd::PropertyTable<csd::ElementSettings>;

constexpr const char *no_memory =
    "Out of memory while tracking. Track fewer features (max-features), or smaller pictures.";
const csd::Guard guard(gst_csd_track_debug, no_memory, "Tracking failed", "");
/// For failures in a frame, which may go on without tracks.
const csd::Guard frame_guard(gst_csd_track_debug, no_memory, "Tracking failed",
                             "Set on-error=pass to keep the video running without tracks.");

// ---- Frames --------------------------------------------------------------------------------------------------------

std::int64_t core_time(GstClockTime time) {
  return time <= static_cast<GstClockTime>(G_MAXINT64) ? static_cast<std::int64_t>(time) : csd::no_time;
}

csd::Tracks track_blind(GstCsdTrack *self, GstBuffer *buffer) {
  auto &state = *self->state;
  return state.engine->tracker.process_blind(state.stream.width, state.stream.height, core_time(GST_BUFFER_PTS(buffer)),
                                             core_time(GST_BUFFER_DURATION(buffer)), GST_BUFFER_IS_DISCONT(buffer));
}

/// points=truth: passes the points the simulator calls visible to the tracker. The tracker takes them when a stream
/// begins.
void offer_truth(GstCsdTrack *self, GstBuffer *buffer, const csd::FrameView &view) {
  auto &state = *self->state;
  auto points = csd::visible_truth(buffer, view.width, view.height);
  const bool none = !points;
  state.engine->tracker.offer_start(points ? std::move(*points) : std::vector<csd::StartPoint>());
  if (none && state.stream.frame == 0)
    GST_ELEMENT_WARNING(self, STREAM, FAILED,
                        ("points=truth, but the first frame carries no truth of a picture of its size. Put csdsimsrc "
                         "upstream, or name the points."),
                        ("nothing is tracked until a frame carries it"));
}

/// Maps read-only, because a writable map of a shared buffer copies its pixels.
csd::Tracks track(GstCsdTrack *self, GstBuffer *buffer) {
  auto &state = *self->state;
  if (csd::views_take_turns(GST_VIDEO_FILTER(self)->in_info))
    throw std::runtime_error(
        "the views of this stream come frame by frame (multiview-mode), and one tracker can't follow two of them: give "
        "each view a stream and a csdtrack of its own");
  if (csd::is_empty_gap(buffer)) return track_blind(self, buffer);
  csd::MappedFrame frame(GST_VIDEO_FILTER(self)->in_info, buffer, GST_MAP_READ);
  const csd::FrameView view =
      csd::frame_view(*frame, GST_VIDEO_FILTER(self)->in_info, gst_buffer_get_video_crop_meta(buffer));
  if (view.width < 1 || view.height < 1) throw std::runtime_error("a frame's crop rectangle lies outside the frame");
  state.stream.width = view.width;
  state.stream.height = view.height;
  if (state.points_from_truth) offer_truth(self, buffer, view);
  return state.engine->tracker.process(view, core_time(GST_BUFFER_PTS(buffer)), core_time(GST_BUFFER_DURATION(buffer)),
                                       GST_BUFFER_IS_DISCONT(buffer));
}

/// Publishes the tracks: meta, regions of interest, message. The overlay comes last, so an exception in it affects none
/// of them.
void publish(GstCsdTrack *self, GstBuffer *buffer, const csd::Tracks &tracks, const csd::LiveSettings &live) {
  auto &state = *self->state;
  const char *algorithm = csd::algorithm_name(state.algorithm).data();
  if (live.attach_meta) csd::add_track_meta(buffer, tracks, GST_OBJECT_NAME(self), algorithm);
  const csd::PatchBoxes boxes(GST_VIDEO_FILTER(self)->in_info, buffer, tracks.height, state.patch_size);
  const auto times = csd::frame_times(GST_BASE_TRANSFORM(self)->segment, buffer);
  if (live.attach_roi) csd::attach_rois(buffer, boxes, tracks);
#ifdef CSDTRACK_ANALYTICS
  if (live.attach_analytics) state.stream.analytics.attach(buffer, boxes, tracks, times.running_time);
#endif
  state.stream.messages.frame(GST_ELEMENT(self), algorithm, live, tracks, times);
}

void warn_once(GstCsdTrack *self, const csd::Failure &failure) {
  auto &stream = self->state->stream;
  GST_WARNING_OBJECT(self, "frame %" G_GUINT64_FORMAT ": %s", stream.frame, failure.detail.c_str());
  if (std::exchange(stream.warned_failure, true)) return;
  GST_ELEMENT_WARNING(self, STREAM, FAILED, ("Frames pass without being tracked. %s", guard.text(failure).get()),
                      ("first at frame %" G_GUINT64_FORMAT ": %s", stream.frame, failure.detail.c_str()));
}

void warn_small_once(GstCsdTrack *self, const csd::Tracks &tracks) {
  if (!tracks.too_small || std::exchange(self->state->stream.warned_small, true)) return;
  GST_ELEMENT_WARNING(self, STREAM, FORMAT,
                      ("A picture of %d×%d pixels is too small to track features in: it is smaller than a feature's "
                       "patch, or than 16 pixels. Set patch-size lower, or leave the picture larger.",
                       tracks.width, tracks.height),
                      ("no features in this stream"));
}

/// Handles one frame. An exception in any part fails the whole frame.
GstFlowReturn handle(GstCsdTrack *self, GstBuffer *buffer, const csd::LiveSettings &live) {
  auto &state = *self->state;
  csd::Tracks tracks;
  auto failure = csd::guarded([&] { tracks = track(self, buffer); });
  const bool failed = failure.has_value();
  if (failed && live.on_error == GST_CSD_TRACK_ON_ERROR_PASS) {
    warn_once(self, *failure);
    guard.logged(self, [&] { tracks = track_blind(self, buffer); });
    failure.reset();
  }
  if (!failure)
    failure = csd::guarded([&] {
      tracks.frame = state.stream.frame;
      warn_small_once(self, tracks);
      publish(self, buffer, tracks, live);
      if (!failed) state.overlay.show(GST_VIDEO_FILTER(self)->in_info, buffer, tracks, live.overlay);
    });
  if (failed || failure) {
    const csd::ObjectLock lock(self);
    ++state.failed_frames;
  }
  ++state.stream.frame;
  if (!failure) return GST_FLOW_OK;
  if (live.on_error == GST_CSD_TRACK_ON_ERROR_PASS) {
    warn_once(self, *failure);
    return GST_FLOW_OK;
  }
  frame_guard.post(self, *failure);
  return GST_FLOW_ERROR;
}

// ---- GstBaseTransform, GstVideoFilter ------------------------------------------------------------------------------

GstFlowReturn gst_csd_track_transform_ip(GstBaseTransform *trans, GstBuffer *buffer) {
  auto *self = GST_CSD_TRACK(trans);
  auto &state = *self->state;
  if (!GST_VIDEO_FILTER(trans)->negotiated || !state.engine) {
    GST_ELEMENT_ERROR(self, CORE, NEGOTIATION, (nullptr), ("a buffer came before its caps"));
    return GST_FLOW_NOT_NEGOTIATED;
  }
  const auto begun = std::chrono::steady_clock::now();
  const csd::LiveSettings live = live_settings(self);
  guard.logged(self, [&] { state.overlay.settle(live.overlay); });
  const GstFlowReturn flow = handle(self, buffer, live);
  const std::chrono::nanoseconds taken = std::chrono::steady_clock::now() - begun;
  const csd::ObjectLock lock(self);
  state.latency.add(static_cast<std::uint64_t>(taken.count()));
  return flow;
}

GstCaps *gst_csd_track_transform_caps(GstBaseTransform *trans, GstPadDirection direction, GstCaps *caps,
                                      GstCaps *filter) {
  return GST_CSD_TRACK(trans)->state->overlay.transform_caps(direction, caps, filter);
}

/// Handles the user's input in the window of a sink that shows this picture.
void navigate(GstCsdTrack *self, GstEvent *event) {
  if (!live_settings(self).navigation) return;
  const auto command = self->state->navigation.read(event);
  const auto engine = engine_of(self);
  if (!command || !engine) return;
  GST_DEBUG_OBJECT(self, "%s %f,%f", csd::command_name(command->kind), command->x, command->y);
  csd::apply(*command, engine->tracker);
}

gboolean gst_csd_track_src_event(GstBaseTransform *trans, GstEvent *event) {
  auto *self = GST_CSD_TRACK(trans);
  guard.logged(self, [&] {
    self->state->overlay.see_event(event);
    if (GST_EVENT_TYPE(event) == GST_EVENT_NAVIGATION) navigate(self, event);
  });
  return GST_BASE_TRANSFORM_CLASS(gst_csd_track_parent_class)->src_event(trans, event);
}

gboolean gst_csd_track_set_info(GstVideoFilter *filter, GstCaps *in, GstVideoInfo *info, GstCaps *out, GstVideoInfo *) {
  auto *self = GST_CSD_TRACK(filter);
  auto &state = *self->state;
  const GstVideoInfo &last = filter->in_info;  // the base class updates it after this call
  const bool same = filter->negotiated && state.stream.width > 0 && last.width == info->width &&
                    last.height == info->height && last.interlace_mode == info->interlace_mode;
  GST_DEBUG_OBJECT(self, "%s %dx%d: the stream is %s", gst_video_format_to_string(GST_VIDEO_INFO_FORMAT(info)),
                   info->width, info->height, same ? "the same" : "another");
  if (const auto failure = csd::guarded([&] {
        state.overlay.set_caps(in, out);
        if (!same && state.stream.width > 0) state.engine->tracker.reset();
      })) {
    if (live_settings(self).on_error != GST_CSD_TRACK_ON_ERROR_PASS) {
      frame_guard.post(self, *failure);
      return FALSE;
    }
    warn_once(self, *failure);
  }
  if (same) return TRUE;
  state.stream.width = info->width;
  state.stream.height = info->height;
  state.stream.warned_small = false;
  return TRUE;
}

/// Forgets the old stream when a new one begins. Posts a pending message when a stream ends.
void handle(GstCsdTrack *self, GstEvent *event) {
  auto &state = *self->state;
  switch (GST_EVENT_TYPE(event)) {
    case GST_EVENT_FLUSH_STOP:
      GST_DEBUG_OBJECT(self, "flush: the stream is forgotten");
      state.stream.messages = {};  // a held-back message belongs to a dropped frame
      state.engine->tracker.reset();
      break;
    case GST_EVENT_STREAM_START: {
      const gchar *id = nullptr;
      gst_event_parse_stream_start(event, &id);
      if (!state.stream.id.empty() && state.stream.id != id) {
        GST_DEBUG_OBJECT(self, "stream %s follows %s, which is forgotten", id, state.stream.id.c_str());
        state.engine->tracker.reset();
      }
      state.stream.id = id;
      break;
    }
    case GST_EVENT_EOS:
      state.stream.messages.end(GST_ELEMENT(self), csd::algorithm_name(state.algorithm).data(), live_settings(self));
      break;
    default:
      break;
  }
}

gboolean gst_csd_track_sink_event(GstBaseTransform *trans, GstEvent *event) {
  auto *self = GST_CSD_TRACK(trans);
  // These events are serialized: they come from the streaming thread, or nothing streams.
  if (self->state->engine) guard.logged(self, [&] { handle(self, event); });
  return GST_BASE_TRANSFORM_CLASS(gst_csd_track_parent_class)->sink_event(trans, event);
}

GstCaps *gst_csd_track_fixate_caps(GstBaseTransform *trans, GstPadDirection direction, GstCaps *caps, GstCaps *other) {
  other = GST_CSD_TRACK(trans)->state->overlay.prefer(direction, other);
  return GST_BASE_TRANSFORM_CLASS(gst_csd_track_parent_class)->fixate_caps(trans, direction, caps, other);
}

/// Asks the base class about caps that include their interlace-mode.
gboolean gst_csd_track_accept_caps(GstBaseTransform *trans, GstPadDirection direction, GstCaps *caps) {
  GstCaps *complete = csd::complete_caps(caps);
  const gboolean accepted =
      GST_BASE_TRANSFORM_CLASS(gst_csd_track_parent_class)->accept_caps(trans, direction, complete);
  gst_caps_unref(complete);
  return accepted;
}

/// Updates controlled properties to the frame's stream time.
void gst_csd_track_before_transform(GstBaseTransform *trans, GstBuffer *buffer) {
  csd::sync_properties(trans, trans->segment, buffer);
}

/// Converts the settings to the core's. Posts an error if they are invalid.
bool read_settings(GstCsdTrack *self, csd::Settings &core, unsigned &threads) {
  return guard.posted(self, [&] {
    csd::ElementSettings settings;
    {
      const csd::ObjectLock lock(self);
      settings = self->state->settings;
    }
    std::string problem;
    core = csd::core_settings(settings, problem);
    if (!problem.empty()) throw csd::Refusal(GST_RESOURCE_ERROR_SETTINGS, problem);
    threads = csd::thread_count(settings.n_threads);
  });
}

/// READY→PAUSED.
gboolean gst_csd_track_start(GstBaseTransform *trans) {
  auto *self = GST_CSD_TRACK(trans);
  auto &state = *self->state;
  csd::Settings settings;
  unsigned threads = 1;
  if (!read_settings(self, settings, threads)) return FALSE;
  std::shared_ptr<Engine> engine;
  const bool made = guard.posted(self, [&] {
    state.stream = {};
    state.algorithm = settings.algorithm;
    state.patch_size = settings.patch_size;
    state.points_from_truth = settings.points_from_start;
    engine = std::make_shared<Engine>(settings, threads);
  });
  if (!made) return FALSE;
  const csd::ObjectLock lock(self);
  state.engine = std::move(engine);
  state.last_stats = {};
  state.latency = {};
  state.failed_frames = 0;
  return TRUE;
}

/// PAUSED→READY: the streaming thread has stopped. Waits for learners at work.
gboolean gst_csd_track_stop(GstBaseTransform *trans) {
  auto *self = GST_CSD_TRACK(trans);
  auto &state = *self->state;
  std::shared_ptr<Engine> engine = engine_of(self);
  if (!engine) return TRUE;
  csd::Stats stats;
  guard.logged(self, [&] { stats = engine->tracker.stats(); });
  {
    const csd::ObjectLock lock(self);
    state.last_stats = stats;
    state.engine.reset();
  }
  return TRUE;
}

// ---- GstElement ----------------------------------------------------------------------------------------------------

void set_running(GstCsdTrack *self, bool running) {
  const csd::ObjectLock lock(self);
  self->state->running = running;
}

GstStateChangeReturn gst_csd_track_change_state(GstElement *element, GstStateChange transition) {
  auto *self = GST_CSD_TRACK(element);
  if (transition == GST_STATE_CHANGE_NULL_TO_READY) {
    csd::Settings settings;
    unsigned threads;
    if (!read_settings(self, settings, threads)) return GST_STATE_CHANGE_FAILURE;
  }
  if (transition == GST_STATE_CHANGE_READY_TO_PAUSED) set_running(self, true);
  const GstStateChangeReturn result = GST_ELEMENT_CLASS(gst_csd_track_parent_class)->change_state(element, transition);
  if (transition == GST_STATE_CHANGE_PAUSED_TO_READY ||
      (transition == GST_STATE_CHANGE_READY_TO_PAUSED && result == GST_STATE_CHANGE_FAILURE))
    set_running(self, false);
  return result;
}

// ---- Signals -------------------------------------------------------------------------------------------------------

guint gst_csd_track_add_point(GstCsdTrack *self, gdouble x, gdouble y) {
  guint id = csd::no_feature;
  guard.logged(self, [&] {
    if (const auto engine = engine_of(self)) id = engine->tracker.add_point(x, y);
  });
  GST_DEBUG_OBJECT(self, "%f,%f is point %u", x, y, id);
  return id;
}

void gst_csd_track_remove_point(GstCsdTrack *self, guint id) {
  bool removed = false;
  guard.logged(self, [&] {
    if (const auto engine = engine_of(self)) removed = engine->tracker.remove_point(id);
  });
  GST_DEBUG_OBJECT(self, "point %u %s", id, removed ? "ends" : "is unknown");
}

void gst_csd_track_reset(GstCsdTrack *self) {
  guard.logged(self, [&] {
    if (const auto engine = engine_of(self)) engine->tracker.reset();
  });
}

// ---- GObject -------------------------------------------------------------------------------------------------------

GstStructure *stats_structure(GstCsdTrack *self) {
  const auto &state = *self->state;
  const auto engine = engine_of(self);
  csd::Stats stats;
  if (engine) stats = engine->tracker.stats();
  csd::Latency latency;
  guint64 failed = 0;
  {
    const csd::ObjectLock lock(self);
    if (!engine) stats = state.last_stats;
    latency = state.latency;
    failed = state.failed_frames;
  }
  return csd::stats_structure(stats, latency, failed);
}

void overlay_changed(gpointer object) {
  auto &state = *GST_CSD_TRACK(object)->state;
  state.overlay.see_value(state.settings.live.overlay);
}

void read_stats(gpointer object, GValue *value) {
  g_value_take_boxed(value, stats_structure(GST_CSD_TRACK(object)));
}

/// Made, and installed, by the first call, in class_init.
const Properties &properties_of(gpointer klass) {
  static const Properties table(G_OBJECT_CLASS(klass), csd::track_properties(overlay_changed, read_stats),
                                gst_csd_track_debug);
  return table;
}

void gst_csd_track_set_property(GObject *object, guint id, const GValue *value, GParamSpec *) {
  auto &state = *GST_CSD_TRACK(object)->state;
  guard.logged(
      object, [&] { properties_of(G_OBJECT_GET_CLASS(object)).set(object, state.settings, state.running, id, value); });
}

void gst_csd_track_get_property(GObject *object, guint id, GValue *value, GParamSpec *) {
  guard.logged(object, [&] {
    properties_of(G_OBJECT_GET_CLASS(object)).get(object, GST_CSD_TRACK(object)->state->settings, id, value);
  });
}

void gst_csd_track_finalize(GObject *object) {
  delete GST_CSD_TRACK(object)->state;
  G_OBJECT_CLASS(gst_csd_track_parent_class)->finalize(object);
}

void add_pad_templates(GstElementClass *klass) {
  GstCaps *caps = csd::template_caps();
  gst_element_class_add_pad_template(klass, gst_pad_template_new("sink", GST_PAD_SINK, GST_PAD_ALWAYS, caps));
  gst_element_class_add_pad_template(klass, gst_pad_template_new("src", GST_PAD_SRC, GST_PAD_ALWAYS, caps));
  gst_caps_unref(caps);
}

void install_signals(GstCsdTrackClass *klass) {
  const GType type = G_TYPE_FROM_CLASS(klass);
  constexpr auto flags = static_cast<GSignalFlags>(G_SIGNAL_RUN_LAST | G_SIGNAL_ACTION);
  /**
   * GstCsdTrack::add-point:
   * @x: pixels of the next frame, centres at integers
   * @y: pixels of the next frame
   *
   * Tracks this point too, from the next frame on. May be emitted from any thread.
   *
   * Returns: the point's id; %G_MAXUINT if a coordinate is not finite, 10000 points are already tracked, or the element
   *   is not yet PAUSED.
   *
   * Since: 0.1
   */
  gst_csd_track_signals[signal_add_point] =
      g_signal_new_class_handler("add-point", type, flags, G_CALLBACK(gst_csd_track_add_point), nullptr, nullptr,
                                 nullptr, G_TYPE_UINT, 2, G_TYPE_DOUBLE, G_TYPE_DOUBLE);
  /**
   * GstCsdTrack::remove-point:
   * @id: of a feature, given or detected
   *
   * Ends that feature with the next frame. Ignores an unknown id.
   *
   * Since: 0.1
   */
  gst_csd_track_signals[signal_remove_point] =
      g_signal_new_class_handler("remove-point", type, flags, G_CALLBACK(gst_csd_track_remove_point), nullptr, nullptr,
                                 nullptr, G_TYPE_NONE, 1, G_TYPE_UINT);
  /**
   * GstCsdTrack::reset:
   *
   * Forgets the stream: the next frame ends all features and starts new ones under new ids.
   *
   * Since: 0.1
   */
  gst_csd_track_signals[signal_reset] = g_signal_new_class_handler(
      "reset", type, flags, G_CALLBACK(gst_csd_track_reset), nullptr, nullptr, nullptr, G_TYPE_NONE, 0);
}

}  // namespace

static void gst_csd_track_class_init(GstCsdTrackClass *klass) {
  auto *object_class = G_OBJECT_CLASS(klass);
  auto *element_class = GST_ELEMENT_CLASS(klass);
  auto *trans_class = GST_BASE_TRANSFORM_CLASS(klass);

  object_class->set_property = gst_csd_track_set_property;
  object_class->get_property = gst_csd_track_get_property;
  object_class->finalize = gst_csd_track_finalize;
  properties_of(klass);
  install_signals(klass);

  gst_element_class_set_static_metadata(element_class, "Tissue tracker", "Filter/Analyzer/Video",
                                        "Tracks points on deforming tissue in endoscopic video",
                                        "The csdtrack authors");
  add_pad_templates(element_class);
  element_class->change_state = GST_DEBUG_FUNCPTR(gst_csd_track_change_state);

  // GstVideoFilter's transform_ip maps read-write, which copies every frame's pixels behind a tee.
  trans_class->transform_ip = GST_DEBUG_FUNCPTR(gst_csd_track_transform_ip);
  trans_class->before_transform = GST_DEBUG_FUNCPTR(gst_csd_track_before_transform);
  trans_class->sink_event = GST_DEBUG_FUNCPTR(gst_csd_track_sink_event);
  trans_class->src_event = GST_DEBUG_FUNCPTR(gst_csd_track_src_event);
  trans_class->transform_caps = GST_DEBUG_FUNCPTR(gst_csd_track_transform_caps);
  trans_class->fixate_caps = GST_DEBUG_FUNCPTR(gst_csd_track_fixate_caps);
  trans_class->accept_caps = GST_DEBUG_FUNCPTR(gst_csd_track_accept_caps);
  trans_class->start = GST_DEBUG_FUNCPTR(gst_csd_track_start);
  trans_class->stop = GST_DEBUG_FUNCPTR(gst_csd_track_stop);
  GST_VIDEO_FILTER_CLASS(klass)->set_info = GST_DEBUG_FUNCPTR(gst_csd_track_set_info);
}

static void gst_csd_track_init(GstCsdTrack *self) {
  auto *trans = GST_BASE_TRANSFORM(self);
  self->state = new GstCsdTrackState(trans);
  gst_base_transform_set_in_place(trans, TRUE);
  gst_base_transform_set_gap_aware(trans, TRUE);
  // Otherwise the base class tries the input's caps first and never offers the feature that overlay=meta needs.
  gst_base_transform_set_prefer_passthrough(trans, FALSE);
  // GstVideoFilter turns it on, which drops late frames before they get here and leaves a hole in a recording.
  gst_base_transform_set_qos_enabled(trans, FALSE);
}
