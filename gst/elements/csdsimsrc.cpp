// SPDX-License-Identifier: LGPL-2.1-or-later
/**
 * SECTION:element-csdsimsrc
 * @title: csdsimsrc
 * @short_description: simulated tissue with exact ground truth
 *
 * Renders deforming tissue as an endoscope sees it. A GstCsdTruthMeta on each frame holds the true position and
 * visibility of points on it. Use it to try out and score trackers, and to build applications without a patient.
 *
 * A frame depends only on the properties and its number: the same properties give the same bytes on every machine of an
 * architecture. The element is seekable, and plays backwards. It renders as fast as downstream takes frames, or with
 * is-live=true at the rate of a camera. If the framerate changes in mid-stream, timestamps and scene go on from where
 * they are.
 *
 * ## Example launch lines
 * |[
 * gst-launch-1.0 csdsimsrc scenario=mixed ! csdtrack points=truth overlay=draw ! autovideosink
 * ]| Tissue, tools, smoke and highlights, tracked.
 * |[
 * gst-launch-1.0 csdsimsrc scenario=zoom style=liver effects="tools=1,noise=2" seed=7 num-buffers=500 \
 *   ! video/x-raw,width=1280,height=720,framerate=30/1 ! x264enc ! mp4mux ! filesink location=liver.mp4
 * ]| A recording.
 *
 * Since: 0.1
 */
#include "elements/csdsimsrc.h"

#include <gst/video/video.h>

#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "caps/frame_mapping.h"
#include "meta/meta.h"
#include "sim/simulator.h"
#include "support/enums.h"
#include "support/guard.h"
#include "support/lock.h"
#include "support/sim_properties.h"
#include "support/sim_texture.h"
#include "text/parse.h"

GST_DEBUG_CATEGORY_STATIC(gst_csd_sim_src_debug);
#define GST_CAT_DEFAULT gst_csd_sim_src_debug

namespace {

// Same enumerators, in the same order, as in the core.
static_assert(GST_CSD_SIM_SCENARIO_CUT + 1 == csd::sim::scenario_count);
static_assert(GST_CSD_SIM_STYLE_PALE + 1 == csd::sim::style_count);

struct ConverterFree {
  void operator()(GstVideoConverter *converter) const { gst_video_converter_free(converter); }
};
struct BufferUnref {
  void operator()(GstBuffer *buffer) const { gst_buffer_unref(buffer); }
};

/// State of the stream. Only the streaming thread uses it, from start() to stop().
struct Stream {
  csd::sim::SimSettings sim;
  std::vector<cv::Point2d> points;  // set by the user
  unsigned features = 0;

  std::optional<csd::sim::Simulator> simulator;
  std::vector<cv::Point2d> surface;  // points in the truth meta
  GstVideoInfo info;
  std::unique_ptr<GstVideoConverter, ConverterFree> converter;  // null: frames are rendered in place
  std::unique_ptr<GstBuffer, BufferUnref> bgr;                  // its input
  GstVideoInfo bgr_info;

  gint64 next = 0;                                 // number of the next frame; backwards, −1 ends
  guint64 first = 0;                               // a frame's number…
  GstClockTime first_time = 0;                     // …and its time: the others follow at the framerate
  GstClockTime sought = GST_CLOCK_TIME_NONE;       // seek target; none: continue at `next`
  bool backwards = false;                          // since the last seek
  guint64 made = 0;                                // buffers since READY
  GstClockTime switched_on = GST_CLOCK_TIME_NONE;  // running time of a live stream's first frame
};

}  // namespace

struct GstCsdSimSrcState {
  // Guarded by the object lock.
  csd::SimValues settings;
  bool running = false;  ///< since READY→PAUSED: the settings are then read-only
  GstVideoInfo info{};   ///< for queries; without a framerate before the caps are known

  Stream stream;
};

struct _GstCsdSimSrc {
  GstPushSrc parent;
  GstCsdSimSrcState *state;
};

G_DEFINE_TYPE_WITH_CODE(GstCsdSimSrc, gst_csd_sim_src, GST_TYPE_PUSH_SRC,
                        GST_DEBUG_CATEGORY_INIT(gst_csd_sim_src_debug, "csdsimsrc", 0, "simulated tissue"))
GST_ELEMENT_REGISTER_DEFINE_WITH_CODE(csdsimsrc, "csdsimsrc", GST_RANK_NONE, GST_TYPE_CSD_SIM_SRC,
                                      csd::register_track_metas())

namespace {

// BGR first, because it is what the simulator renders. The sizes are the simulator's.
#define CSD_SIM_CAPS                                                                                                 \
  "video/x-raw, format=(string){ BGR, RGB, BGRx, RGBx, xRGB, xBGR, BGRA, RGBA, ARGB, ABGR, I420, YV12, NV12, NV21, " \
  "Y42B, Y444, YUY2, UYVY, GRAY8, v210, I420_10LE, I422_10LE, Y444_10LE, P010_10LE, NV16, VUYA, P012_LE, "           \
  "I420_12LE, RGBA64_LE, ARGB64, Y210, Y410, r210, BGR10A2_LE, GRAY10_LE32, GRAY16_LE }, "                           \
  "width=(int)[ 16, 8192 ], height=(int)[ 16, 8192 ], framerate=(fraction)[ 1/2147483647, 2147483647/1 ]"

GstStaticPadTemplate src_template =
    GST_STATIC_PAD_TEMPLATE("src", GST_PAD_SRC, GST_PAD_ALWAYS, GST_STATIC_CAPS(CSD_SIM_CAPS));

Stream &stream_of(GstBaseSrc *src) {
  return GST_CSD_SIM_SRC(src)->state->stream;
}

const csd::Guard guard(gst_csd_sim_src_debug, "Out of memory for the simulated scene. Make smaller pictures.",
                       "The scene can't be simulated", "");

/// Runs `body` and reports its std::invalid_argument as an error in the settings. Returns false after an error.
template <class Body>
bool posted(GstCsdSimSrc *self, Body body) {
  return guard.posted(self, [&] {
    try {
      body();
    } catch (const std::invalid_argument &e) {
      throw csd::Refusal(GST_RESOURCE_ERROR_SETTINGS, e.what());
    }
  });
}

csd::sim::Effects effects_of(const csd::SimValues &settings) {
  auto effects = csd::sim::scenario_effects(static_cast<csd::sim::Scenario>(settings.scenario), settings.strength);
  try {
    effects.set(settings.effects);
  } catch (const std::invalid_argument &e) {
    throw std::invalid_argument(std::string("effects: ") + e.what());
  }
  return effects;
}

/// READY→PAUSED.
gboolean gst_csd_sim_src_start(GstBaseSrc *src) {
  auto *self = GST_CSD_SIM_SRC(src);
  return posted(self, [&] {
    csd::SimValues settings;
    {
      const csd::ObjectLock lock(self);
      settings = self->state->settings;
    }
    Stream stream;
    stream.sim.effects = effects_of(settings);
    stream.sim.seed = settings.seed;
    stream.sim.style = static_cast<csd::sim::Style>(settings.style);
    if (!settings.texture.empty()) stream.sim.texture = csd::load_picture(settings.texture);
    stream.features = settings.features;
    auto points = csd::parse_points(settings.points);
    if (!points) throw std::invalid_argument(points.error);
    stream.points = std::move(points.value);
    gst_video_info_init(&stream.info);
    self->state->stream = std::move(stream);
  });
}

void set_info(GstCsdSimSrc *self, const GstVideoInfo &info) {
  const csd::ObjectLock lock(self);
  self->state->info = info;
}

GstVideoInfo info_of(GstCsdSimSrc *self) {
  const csd::ObjectLock lock(self);
  return self->state->info;
}

gboolean gst_csd_sim_src_stop(GstBaseSrc *src) {
  stream_of(src) = {};
  set_info(GST_CSD_SIM_SRC(src), {});
  return TRUE;
}

/// Sets the interlace-mode when the frames are interlaced.
GstCaps *gst_csd_sim_src_get_caps(GstBaseSrc *src, GstCaps *filter) {
  auto *self = GST_CSD_SIM_SRC(src);
  GstCaps *caps = gst_pad_get_pad_template_caps(GST_BASE_SRC_PAD(src));
  bool interlaced = false;
  // start() reports unreadable text.
  csd::guarded([&] {
    csd::SimValues settings;
    {
      const csd::ObjectLock lock(self);
      settings = self->state->settings;
    }
    interlaced = effects_of(settings)[csd::sim::Effect::interlacing] > 0;
  });
  caps = gst_caps_make_writable(caps);
  gst_caps_set_simple(caps, "interlace-mode", G_TYPE_STRING, interlaced ? "interleaved" : "progressive", nullptr);
  if (interlaced) gst_caps_set_simple(caps, "field-order", G_TYPE_STRING, "top-field-first", nullptr);
  if (!filter) return caps;
  GstCaps *both = gst_caps_intersect_full(filter, caps, GST_CAPS_INTERSECT_FIRST);
  gst_caps_unref(caps);
  return both;
}

GstCaps *gst_csd_sim_src_fixate(GstBaseSrc *src, GstCaps *caps) {
  caps = gst_caps_make_writable(gst_caps_truncate(caps));
  GstStructure *s = gst_caps_get_structure(caps, 0);
  gst_structure_fixate_field_nearest_int(s, "width", 640);
  gst_structure_fixate_field_nearest_int(s, "height", 480);
  gst_structure_fixate_field_nearest_fraction(s, "framerate", 25, 1);
  if (gst_structure_has_field(s, "pixel-aspect-ratio"))
    gst_structure_fixate_field_nearest_fraction(s, "pixel-aspect-ratio", 1, 1);
  return GST_BASE_SRC_CLASS(gst_csd_sim_src_parent_class)->fixate(src, caps);
}

/// The duration of `frames` frames.
GstClockTime duration_of(const GstVideoInfo &info, guint64 frames) {
  return gst_util_uint64_scale(frames, GST_SECOND * static_cast<guint64>(info.fps_d), static_cast<guint64>(info.fps_n));
}

GstClockTime time_of(const Stream &stream, gint64 frame) {
  return stream.first_time + duration_of(stream.info, static_cast<guint64>(frame) - stream.first);
}

/// Counts frames from the start of the stream at the present rate, as if there had been no other one, and goes to
/// `time`: to the frame shown then or, backwards, to the last that begins before.
void place(Stream &stream, GstClockTime time) {
  stream.first = 0;
  stream.first_time = 0;
  stream.next = static_cast<gint64>(gst_util_uint64_scale(time, static_cast<guint64>(stream.info.fps_n),
                                                          GST_SECOND * static_cast<guint64>(stream.info.fps_d)));
  if (time_of(stream, stream.next + 1) <= time) ++stream.next;  // its timestamp was rounded down
  if (stream.backwards && time_of(stream, stream.next) >= time) --stream.next;
}

/// Makes the scene show the time of the timestamps.
void retime(Stream &stream) {
  stream.simulator->retime(static_cast<double>(stream.info.fps_n) / stream.info.fps_d, stream.first,
                           static_cast<double>(stream.first_time) / GST_SECOND);
}

void make_converter(Stream &stream, const GstVideoInfo &info) {
  stream.converter.reset();
  stream.bgr.reset();
  if (GST_VIDEO_INFO_FORMAT(&info) == GST_VIDEO_FORMAT_BGR) return;
  gst_video_info_set_interlaced_format(&stream.bgr_info, GST_VIDEO_FORMAT_BGR, info.interlace_mode,
                                       static_cast<guint>(info.width), static_cast<guint>(info.height));
  stream.bgr_info.fps_n = info.fps_n;
  stream.bgr_info.fps_d = info.fps_d;
  stream.converter.reset(gst_video_converter_new(&stream.bgr_info, &info, nullptr));
  stream.bgr.reset(gst_buffer_new_allocate(nullptr, stream.bgr_info.size, nullptr));
  if (!stream.converter || !stream.bgr) throw std::runtime_error("no conversion from BGR to this format");
}

/// The scene depends on the frame's size. The rate counts for its first frame, on which points are detected.
void make_scene(Stream &stream, const GstVideoInfo &info) {
  const cv::Size size(info.width, info.height);
  if (stream.simulator && stream.sim.size == size) return;
  stream.simulator.reset();
  stream.sim.size = size;
  stream.sim.rate = static_cast<double>(info.fps_n) / info.fps_d;
  stream.simulator.emplace(stream.sim);
  const auto pixels = stream.points.empty() ? stream.simulator->detect(stream.features) : stream.points;
  stream.surface = stream.simulator->on_surface(0, pixels);
  GST_DEBUG("%dx%d, %zu points", info.width, info.height, pixels.size());
}

gboolean gst_csd_sim_src_set_caps(GstBaseSrc *src, GstCaps *caps) {
  auto *self = GST_CSD_SIM_SRC(src);
  Stream &stream = self->state->stream;
  GstVideoInfo info;
  if (!gst_video_info_from_caps(&info, caps)) return FALSE;
  const GstVideoInfo before = stream.info;
  const bool another_rate = before.fps_n != info.fps_n || before.fps_d != info.fps_d;
  const bool made = posted(self, [&] {
    make_converter(stream, info);
    make_scene(stream, info);
    // A new rate holds from the end of the last frame on, backwards from its begin.
    const bool goes_on = another_rate && before.fps_n > 0 && stream.next >= 0;
    const GstClockTime now = goes_on ? time_of(stream, stream.next + (stream.backwards ? 1 : 0)) : 0;
    stream.info = info;
    if (goes_on && stream.backwards) {
      place(stream, now);
    } else if (goes_on) {
      stream.first = static_cast<guint64>(stream.next);
      stream.first_time = now;
    }
    retime(stream);
  });
  if (!made) return FALSE;
  set_info(self, info);
  gst_base_src_set_blocksize(src, static_cast<guint>(info.size));
  if (another_rate && gst_base_src_is_live(src))
    gst_element_post_message(GST_ELEMENT_CAST(self), gst_message_new_latency(GST_OBJECT_CAST(self)));
  return TRUE;
}

void render(Stream &stream, const GstVideoInfo &info, GstBuffer *buffer) {
  csd::MappedFrame frame(info, buffer, GST_MAP_WRITE);
  // Already has the expected size and type, so the simulator doesn't reallocate it.
  cv::Mat picture(info.height, info.width, CV_8UC3, GST_VIDEO_FRAME_PLANE_DATA(&*frame, 0),
                  static_cast<std::size_t>(GST_VIDEO_FRAME_PLANE_STRIDE(&*frame, 0)));
  stream.simulator->render(static_cast<guint64>(stream.next), picture);
}

csd::Tracks truth_of(Stream &stream) {
  using csd::sim::Visibility;
  csd::Tracks tracks;
  tracks.frame = stream.made;
  tracks.width = stream.info.width;
  tracks.height = stream.info.height;
  for (const auto &p : stream.simulator->truth(static_cast<guint64>(stream.next), stream.surface)) {
    const bool seen = p.visibility == Visibility::visible;
    const auto state = seen                                 ? csd::FeatureState::tracked
                       : p.visibility == Visibility::hidden ? csd::FeatureState::occluded
                                                            : csd::FeatureState::out;
    tracks.features.push_back({p.id, p.x, p.y, state, seen ? 1.0 : 0.0, true});
  }
  return tracks;
}

/// Renders the next frame, with its truth.
void draw(GstCsdSimSrc *self, Stream &stream, GstBuffer *buffer) {
  if (stream.converter) {
    render(stream, stream.bgr_info, stream.bgr.get());
    csd::MappedFrame from(stream.bgr_info, stream.bgr.get(), GST_MAP_READ), to(stream.info, buffer, GST_MAP_WRITE);
    gst_video_converter_frame(stream.converter.get(), &*from, &*to);
  } else {
    render(stream, stream.info, buffer);
  }
  csd::add_truth_meta(buffer, truth_of(stream), GST_OBJECT_NAME(self));
}

void stamp(const Stream &stream, GstBuffer *buffer, GstClockTime pts) {
  GST_BUFFER_PTS(buffer) = pts;
  GST_BUFFER_DTS(buffer) = GST_CLOCK_TIME_NONE;
  GST_BUFFER_DURATION(buffer) = time_of(stream, stream.next + 1) - time_of(stream, stream.next);
  GST_BUFFER_OFFSET(buffer) = static_cast<guint64>(stream.next);
  GST_BUFFER_OFFSET_END(buffer) = static_cast<guint64>(stream.next) + 1;
  if (GST_VIDEO_INFO_IS_INTERLACED(&stream.info))
    GST_BUFFER_FLAG_SET(buffer, GST_VIDEO_BUFFER_FLAG_INTERLACED | GST_VIDEO_BUFFER_FLAG_TFF);
}

GstFlowReturn gst_csd_sim_src_fill(GstPushSrc *push, GstBuffer *buffer) {
  auto *src = GST_BASE_SRC(push);
  auto *self = GST_CSD_SIM_SRC(push);
  Stream &stream = self->state->stream;
  if (!stream.simulator) return GST_FLOW_NOT_NEGOTIATED;
  if (GST_CLOCK_TIME_IS_VALID(stream.sought)) {
    place(stream, std::exchange(stream.sought, GST_CLOCK_TIME_NONE));
    if (!guard.posted(self, [&] { retime(stream); })) return GST_FLOW_ERROR;
  }
  if (stream.next < 0) return GST_FLOW_EOS;
  GstClockTime pts = time_of(stream, stream.next);
  if (gst_base_src_is_live(src)) {
    // A camera's first frame is stamped with the time it was switched on. Creating the scene took a while.
    if (!GST_CLOCK_TIME_IS_VALID(stream.switched_on)) {
      const GstClockTime now = gst_element_get_current_running_time(GST_ELEMENT_CAST(src));
      stream.switched_on = GST_CLOCK_TIME_IS_VALID(now) ? now : 0;
    }
    pts += stream.switched_on;
  } else if (!stream.backwards && GST_CLOCK_TIME_IS_VALID(src->segment.stop) && pts >= src->segment.stop) {
    return GST_FLOW_EOS;
  }
  if (!guard.posted(self, [&] { draw(self, stream, buffer); })) return GST_FLOW_ERROR;
  stamp(stream, buffer, pts);
  stream.next += stream.backwards ? -1 : 1;  // backwards, GstBaseSrc ends at the segment's start
  ++stream.made;
  return GST_FLOW_OK;
}

/// A live frame is complete at the end of its exposure.
void gst_csd_sim_src_get_times(GstBaseSrc *src, GstBuffer *buffer, GstClockTime *start, GstClockTime *end) {
  *start = *end = GST_CLOCK_TIME_NONE;
  if (!gst_base_src_is_live(src)) return;
  *start = GST_BUFFER_PTS(buffer);
  *end = *start + GST_BUFFER_DURATION(buffer);
}

/// Like videotestsrc: a live frame leaves at its timestamp or, while it is being rendered, later, but within its
/// duration. With a latency of 0 the sink would find every frame late. There is no maximum latency: the element drops
/// nothing.
gboolean answer_latency(const GstVideoInfo &info, GstQuery *query) {
  if (info.fps_n == 0) return FALSE;
  gst_query_set_latency(query, TRUE, duration_of(info, 1), GST_CLOCK_TIME_NONE);
  return TRUE;
}

/// num-buffers, as a duration at the present rate. False where it is unlimited, or the caps are unknown.
gboolean answer_duration(const GstVideoInfo &info, gint frames, GstQuery *query) {
  if (frames < 0 || info.fps_n == 0) return FALSE;
  GstFormat format = GST_FORMAT_UNDEFINED;
  gst_query_parse_duration(query, &format, nullptr);
  const auto n = static_cast<guint64>(frames);
  guint64 duration = n;
  if (format == GST_FORMAT_TIME)
    duration = duration_of(info, n);
  else if (format == GST_FORMAT_BYTES)
    duration = n * info.size;
  else if (format != GST_FORMAT_DEFAULT)
    return FALSE;
  gst_query_set_duration(query, format, static_cast<gint64>(duration));
  return TRUE;
}

/// Between frames, time and bytes, at the present rate.
gboolean answer_convert(const GstVideoInfo &info, GstQuery *query) {
  if (info.fps_n == 0) return FALSE;
  GstFormat from = GST_FORMAT_UNDEFINED, to = GST_FORMAT_UNDEFINED;
  gint64 value = 0, converted = 0;
  gst_query_parse_convert(query, &from, &value, &to, nullptr);
  if (!gst_video_info_convert(&info, from, value, to, &converted)) return FALSE;
  gst_query_set_convert(query, from, value, to, converted);
  return TRUE;
}

gboolean gst_csd_sim_src_query(GstBaseSrc *src, GstQuery *query) {
  const GstVideoInfo info = info_of(GST_CSD_SIM_SRC(src));
  switch (GST_QUERY_TYPE(query)) {
    case GST_QUERY_LATENCY:
      if (gst_base_src_is_live(src)) return answer_latency(info, query);
      break;
    case GST_QUERY_DURATION:
      if (answer_duration(info, src->num_buffers, query)) return TRUE;
      break;
    case GST_QUERY_CONVERT:
      if (answer_convert(info, query)) return TRUE;
      break;
    default:
      break;
  }
  return GST_BASE_SRC_CLASS(gst_csd_sim_src_parent_class)->query(src, query);
}

gboolean gst_csd_sim_src_is_seekable(GstBaseSrc *src) {
  return !gst_base_src_is_live(src);
}

gboolean gst_csd_sim_src_do_seek(GstBaseSrc *src, GstSegment *segment) {
  if (segment->format != GST_FORMAT_TIME) return FALSE;
  Stream &stream = stream_of(src);
  if (segment->rate < 0 && !GST_CLOCK_TIME_IS_VALID(segment->stop)) {
    // Backwards from the end, where there is one.
    if (src->num_buffers < 0 || stream.info.fps_n == 0) return FALSE;
    const GstClockTime end = duration_of(stream.info, static_cast<guint64>(src->num_buffers));
    segment->stop = segment->position = MAX(segment->start, end);
  }
  // Turned into a frame number later, because the caps may not be known yet.
  stream.sought = segment->position;
  stream.backwards = segment->rate < 0;
  segment->time = segment->start;
  return TRUE;
}

void set_running(GstCsdSimSrc *self, bool running) {
  const csd::ObjectLock lock(self);
  self->state->running = running;
}

GstStateChangeReturn gst_csd_sim_src_change_state(GstElement *element, GstStateChange transition) {
  auto *self = GST_CSD_SIM_SRC(element);
  if (transition == GST_STATE_CHANGE_READY_TO_PAUSED) set_running(self, true);
  const GstStateChangeReturn result =
      GST_ELEMENT_CLASS(gst_csd_sim_src_parent_class)->change_state(element, transition);
  if (transition == GST_STATE_CHANGE_PAUSED_TO_READY ||
      (transition == GST_STATE_CHANGE_READY_TO_PAUSED && result == GST_STATE_CHANGE_FAILURE))
    set_running(self, false);
  return result;
}

const csd::PropertyTable<csd::SimValues> &properties_of(gpointer klass) {
  static const csd::PropertyTable<csd::SimValues> table(G_OBJECT_CLASS(klass), csd::sim_properties(), GST_CAT_DEFAULT);
  return table;
}

void gst_csd_sim_src_set_property(GObject *object, guint id, const GValue *value, GParamSpec *) {
  auto *self = GST_CSD_SIM_SRC(object);
  GstCsdSimSrcState &state = *self->state;
  bool set = false;
  guard.logged(self, [&] {
    set = properties_of(G_OBJECT_GET_CLASS(object)).set(self, state.settings, state.running, id, value);
  });
  if (!set) return;
  gboolean live;
  {
    const csd::ObjectLock lock(self);
    live = state.settings.is_live;
  }
  gst_base_src_set_live(GST_BASE_SRC(object), live);
}

void gst_csd_sim_src_get_property(GObject *object, guint id, GValue *value, GParamSpec *) {
  auto *self = GST_CSD_SIM_SRC(object);
  properties_of(G_OBJECT_GET_CLASS(object)).get(self, self->state->settings, id, value);
}

void gst_csd_sim_src_finalize(GObject *object) {
  delete GST_CSD_SIM_SRC(object)->state;
  G_OBJECT_CLASS(gst_csd_sim_src_parent_class)->finalize(object);
}

}  // namespace

static void gst_csd_sim_src_class_init(GstCsdSimSrcClass *klass) {
  auto *object_class = G_OBJECT_CLASS(klass);
  auto *element_class = GST_ELEMENT_CLASS(klass);
  auto *src_class = GST_BASE_SRC_CLASS(klass);
  object_class->set_property = gst_csd_sim_src_set_property;
  object_class->get_property = gst_csd_sim_src_get_property;
  object_class->finalize = gst_csd_sim_src_finalize;
  properties_of(object_class);

  gst_element_class_add_static_pad_template(element_class, &src_template);
  gst_element_class_set_static_metadata(element_class, "Tissue simulator", "Source/Video",
                                        "Simulated endoscopic video of deforming tissue with exact ground truth",
                                        "The csdtrack authors");
  element_class->change_state = GST_DEBUG_FUNCPTR(gst_csd_sim_src_change_state);
  src_class->start = GST_DEBUG_FUNCPTR(gst_csd_sim_src_start);
  src_class->stop = GST_DEBUG_FUNCPTR(gst_csd_sim_src_stop);
  src_class->get_caps = GST_DEBUG_FUNCPTR(gst_csd_sim_src_get_caps);
  src_class->fixate = GST_DEBUG_FUNCPTR(gst_csd_sim_src_fixate);
  src_class->set_caps = GST_DEBUG_FUNCPTR(gst_csd_sim_src_set_caps);
  src_class->get_times = GST_DEBUG_FUNCPTR(gst_csd_sim_src_get_times);
  src_class->query = GST_DEBUG_FUNCPTR(gst_csd_sim_src_query);
  src_class->is_seekable = GST_DEBUG_FUNCPTR(gst_csd_sim_src_is_seekable);
  src_class->do_seek = GST_DEBUG_FUNCPTR(gst_csd_sim_src_do_seek);
  GST_PUSH_SRC_CLASS(klass)->fill = GST_DEBUG_FUNCPTR(gst_csd_sim_src_fill);
}

static void gst_csd_sim_src_init(GstCsdSimSrc *self) {
  self->state = new GstCsdSimSrcState();
  gst_base_src_set_format(GST_BASE_SRC(self), GST_FORMAT_TIME);
}
