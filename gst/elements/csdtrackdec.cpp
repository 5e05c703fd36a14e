// SPDX-License-Identifier: LGPL-2.1-or-later
/**
 * SECTION:element-csdtrackdec
 * @title: csdtrackdec
 * @short_description: puts recorded tracks back on the frames
 *
 * Reads the lines that csdtrackenc wrote and attaches the tracks of each frame as a #GstCustomMeta again, as csdtrack
 * or a simulator did: `GstCsdTrackMeta`, or `GstCsdTruthMeta` where the line's role is `truth`. It does no tracking.
 * With #GstCsdTrackDec:overlay it also shows the tracks. Use it to review a recording without tracking it again.
 *
 * The lines come from a file, #GstCsdTrackDec:location, or from the request pad `text`: JSON lines as a byte stream, a
 * recording's text track, or KLV, as from MPEG-TS and RTP. A frame gets the line nearest in stream time, at most half a
 * frame away. Positions are scaled from the line's picture to the frame's. Live, the latency covers both pads, and no
 * frame waits longer for its line.
 *
 * Unless #GstCsdTrackDec:overlay=draw, the element maps no pixels, so they may be in any memory.
 *
 * ## Example launch lines
 *
 * |[
 * gst-launch-1.0 filesrc location=operation.mp4 ! decodebin ! csdtrackdec location=operation.jsonl overlay=draw \
 *   ! videoconvert ! autovideosink
 * ]| Shows a recording with its tracks.
 * |[
 * gst-launch-1.0 filesrc location=operation.mkv ! matroskademux name=d csdtrackdec name=r overlay=draw \
 *   ! videoconvert ! autovideosink \
 *   d.video_0 ! queue ! decodebin ! r.sink \
 *   d.subtitle_0 ! queue max-size-time=0 max-size-buffers=1000 ! r.text
 * ]| The same for tracks in a recording's text track. Both queues are needed: a frame waits for its text.
 *
 * Since: 0.1
 */
#include "elements/csdtrackdec.h"

#include <algorithm>
#include <atomic>
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "caps/frame_mapping.h"
#include "caps/frame_time.h"
#include "meta/meta.h"
#include "overlay/overlay.h"
#include "record/frame_events.h"
#include "record/frame_limit.h"
#include "record/text_lines.h"
#include "record/track_file.h"
#include "record/track_queue.h"
#include "record/upstream_latency.h"
#include "support/guard.h"
#include "support/lock.h"

GST_DEBUG_CATEGORY_STATIC(gst_csd_track_dec_debug);
#define GST_CAT_DEFAULT gst_csd_track_dec_debug

namespace {

constexpr GstClockTime default_max_wait = 5 * GST_SECOND;

constexpr gint64 max_offset = 1000000000 * gint64{GST_SECOND};  // 31 years, so sums don't overflow

enum Property : guint { prop_0, prop_location, prop_overlay, prop_max_wait, prop_ts_offset, prop_min_upstream_latency };

/// Copied once per frame.
struct LiveSettings {
  GstCsdTrackOverlay overlay = GST_CSD_TRACK_OVERLAY_NONE;
  GstClockTime max_wait = default_max_wait;
  std::int64_t ts_offset = 0;
};

/// State of the video's streaming thread, from READY to READY.
struct Video {
  bool warned_aspect = false, warned_late = false, warned_nothing = false;
};

/// State of the text's streaming thread, from READY to READY.
struct Text {
  csd::TextLines lines;
  bool flowing = false, refused = false, warned_unread = false, warned_torn = false, warned_others = false;
};

}  // namespace

/// The C++ members, with destructors.
struct GstCsdTrackDecState {
  explicit GstCsdTrackDecState(GstBaseTransform *element)
      : overlay(GST_ELEMENT(element), element->sinkpad, element->srcpad) {}

  // Guarded by the object lock, held only for a copy.
  std::string location;
  LiveSettings live;
  bool running = false;  ///< since READY→PAUSED; location is then read-only

  csd::Overlay overlay;          ///< documents which thread may call what
  csd::TrackQueue queue;         ///< thread-safe
  csd::UpstreamLatency latency;  ///< thread-safe

  std::unique_ptr<csd::TrackFile> file;  ///< video thread only; created and destroyed in state changes only
  Video video;
  Text text;
  std::atomic<bool> playing = false;
  std::atomic<bool> text_unlinked = false;  ///< relinking the same pads brings no STREAM_START
};

struct _GstCsdTrackDec {
  GstVideoFilter parent;
  GstCsdTrackDecState *state;
};

G_DEFINE_TYPE_WITH_CODE(GstCsdTrackDec, gst_csd_track_dec, GST_TYPE_VIDEO_FILTER,
                        GST_DEBUG_CATEGORY_INIT(gst_csd_track_dec_debug, "csdtrackdec", 0, "recorded tracks"))
GST_ELEMENT_REGISTER_DEFINE_WITH_CODE(csdtrackdec, "csdtrackdec", GST_RANK_NONE, GST_TYPE_CSD_TRACK_DEC,
                                      csd::register_track_metas())

static GstStaticPadTemplate text_template =
    GST_STATIC_PAD_TEMPLATE("text", GST_PAD_SINK, GST_PAD_REQUEST,
                            GST_STATIC_CAPS("application/x-ndjson; text/x-raw, format=(string){ utf8, pango-markup }; "
                                            "meta/x-klv"));

namespace {

LiveSettings live_settings(GstCsdTrackDec *self) {
  const csd::ObjectLock lock(self);
  return self->state->live;
}

const csd::Guard guard(gst_csd_track_dec_debug,
                       "Out of memory for recorded tracks. Use overlay=none, or smaller pictures.",
                       "Recorded tracks could not be put on a frame", "Use overlay=none, or smaller pictures.");

// ---- A frame -------------------------------------------------------------------------------------------------------

using PadPtr = std::unique_ptr<GstPad, decltype(&gst_object_unref)>;

/// The pad `text`, if it exists and is in use.
PadPtr text_pad(GstCsdTrackDec *self) {
  bool read = false;
  {
    const csd::ObjectLock lock(self);
    read = self->state->location.empty();
  }
  return {read ? gst_element_get_static_pad(GST_ELEMENT(self), "text") : nullptr, gst_object_unref};
}

void warn_late_once(GstCsdTrackDec *self, GstClockTime limit, bool is_latency) {
  if ((limit == 0 && !is_latency) || std::exchange(self->state->video.warned_late, true)) return;
  GST_ELEMENT_WARNING(
      self, STREAM, FAILED,
      ("Frames pass without tracks: no text has come within %" G_GUINT64_FORMAT
       " ms%s. Put a queue before each pad of csdtrackdec, or set %s higher.",
       limit / GST_MSECOND, is_latency ? ", the latency" : "", is_latency ? "min-upstream-latency" : "max-wait"),
      ("what comes later is left out"));
}

void warn_nothing_once(GstCsdTrackDec *self) {
  if (std::exchange(self->state->video.warned_nothing, true)) return;
  GST_ELEMENT_WARNING(
      self, RESOURCE, SETTINGS,
      ("There are no tracks to put on the frames. Set location to a .jsonl file of csdtrackenc, or link "
       "a stream of its lines to the pad text."),
      (nullptr));
}

/// Waits for the frame's line like GstAggregator: live, at most the latency that downstream knows.
csd::TrackQueue::Match await_line(GstCsdTrackDec *self, GstBuffer *buffer, const csd::FrameTime &when,
                                  GstClockTime max_wait) {
  auto &state = *self->state;
  const unsigned thought = state.queue.thoughts();
  auto latency = state.latency.current(GST_ELEMENT(self), GST_BASE_TRANSFORM_SINK_PAD(self), text_pad(self).get());
  if (!state.playing) latency.reset();
  const auto limit =
      csd::frame_limit(GST_ELEMENT(self), GST_BASE_TRANSFORM(self)->segment, GST_BUFFER_PTS(buffer), latency, max_wait);
  auto match = state.queue.match(*when.time, when.reach, limit, thought);
  if (match.outcome == csd::TrackQueue::Outcome::late)
    warn_late_once(self, limit.by_latency ? latency->min : max_wait, limit.by_latency);
  return match;
}

/// The frame's line, if any. `flushing`: the frame may be dropped.
std::optional<csd::TimedLine> find_line(GstCsdTrackDec *self, GstBuffer *buffer, const LiveSettings &live,
                                        bool &flushing) {
  auto &state = *self->state;
  const GstSegment &segment = GST_BASE_TRANSFORM(self)->segment;
  csd::FrameTime when = csd::frame_time(segment, GST_VIDEO_FILTER(self)->in_info, buffer);
  if (!state.file && !state.queue.linked()) warn_nothing_once(self);
  if (!when.time) return std::nullopt;
  *when.time -= live.ts_offset;  // in the time of the lines
  if (state.file) return state.file->at(*when.time, when.reach);
  if (segment.rate < 0) return std::nullopt;
  csd::TrackQueue::Match match{csd::TrackQueue::Outcome::again, std::nullopt};
  while (match.outcome == csd::TrackQueue::Outcome::again) match = await_line(self, buffer, when, live.max_wait);
  flushing = match.outcome == csd::TrackQueue::Outcome::flushing;
  return std::move(match.line);
}

/// Scales the line's tracks to the frame's picture. Returns false if they don't fit it.
bool fit(GstCsdTrackDec *self, GstBuffer *buffer, csd::Tracks &tracks) {
  const csd::PictureArea area = csd::picture_area(buffer, GST_VIDEO_FILTER(self)->in_info);
  if (area.width < 1 || area.height < 1) return false;
  const int width = tracks.width, height = tracks.height;
  if (csd::scale_tracks(tracks, area.width, area.height)) return true;
  if (!std::exchange(self->state->video.warned_aspect, true))
    GST_ELEMENT_WARNING(self, STREAM, FORMAT,
                        ("Frames pass without tracks: these are of a picture of %d×%d pixels, and the video, of %d×%d, "
                         "has another aspect. Give csdtrackdec the video that was tracked, or scale it in proportion.",
                         width, height, area.width, area.height),
                        ("borders can't be told from distortion"));
  return false;
}

/// Attaches the line's tracks to the frame and shows them.
void put(GstCsdTrackDec *self, GstBuffer *buffer, csd::TrackLine &line, GstCsdTrackOverlay overlay) {
  GST_LOG_OBJECT(self, "frame at %" GST_TIME_FORMAT ": line of frame %" G_GUINT64_FORMAT ", %u features",
                 GST_TIME_ARGS(GST_BUFFER_PTS(buffer)), line.tracks.frame,
                 static_cast<unsigned>(line.tracks.features.size()));
  if (!line.numbered) return;  // the frame had no tracks when recorded
  const int width = line.tracks.width, height = line.tracks.height;
  if (!fit(self, buffer, line.tracks)) return;
  GstCustomMeta *meta = csd::add_tracks(buffer, line.truth ? GST_CSD_TRUTH_META_NAME : GST_CSD_TRACK_META_NAME,
                                        line.tracks, line.source.c_str(), line.algorithm.c_str());
  if (meta)
    gst_structure_set(gst_custom_meta_get_structure(meta), "tracked-width", G_TYPE_INT, width, "tracked-height",
                      G_TYPE_INT, height, nullptr);
  self->state->overlay.show(GST_VIDEO_FILTER(self)->in_info, buffer, line.tracks, overlay);
}

// ---- GstBaseTransform, GstVideoFilter ------------------------------------------------------------------------------

GstFlowReturn gst_csd_track_dec_transform_ip(GstBaseTransform *trans, GstBuffer *buffer) {
  auto *self = GST_CSD_TRACK_DEC(trans);
  if (!GST_VIDEO_FILTER(trans)->negotiated) {
    GST_ELEMENT_ERROR(self, CORE, NEGOTIATION, (nullptr), ("a buffer came before its caps"));
    return GST_FLOW_NOT_NEGOTIATED;
  }
  const LiveSettings live = live_settings(self);
  if (!self->state->overlay.can_show(live.overlay)) return GST_FLOW_NOT_NEGOTIATED;
  bool flushing = false;
  const bool done = guard.posted(self, [&] {
    self->state->overlay.settle(live.overlay);
    auto found = find_line(self, buffer, live, flushing);
    if (found)
      put(self, buffer, found->line, live.overlay);
    else
      GST_LOG_OBJECT(self, "frame at %" GST_TIME_FORMAT ": no line", GST_TIME_ARGS(GST_BUFFER_PTS(buffer)));
  });
  return flushing ? GST_FLOW_FLUSHING : done ? GST_FLOW_OK : GST_FLOW_ERROR;
}

GstCaps *gst_csd_track_dec_transform_caps(GstBaseTransform *trans, GstPadDirection direction, GstCaps *caps,
                                          GstCaps *filter) {
  return GST_CSD_TRACK_DEC(trans)->state->overlay.transform_caps(direction, caps, filter);
}

GstCaps *gst_csd_track_dec_fixate_caps(GstBaseTransform *trans, GstPadDirection direction, GstCaps *caps,
                                       GstCaps *other) {
  other = GST_CSD_TRACK_DEC(trans)->state->overlay.prefer(direction, other);
  return GST_BASE_TRANSFORM_CLASS(gst_csd_track_dec_parent_class)->fixate_caps(trans, direction, caps, other);
}

/// Asks the base class about caps that include their interlace-mode.
gboolean gst_csd_track_dec_accept_caps(GstBaseTransform *trans, GstPadDirection direction, GstCaps *caps) {
  GstCaps *complete = csd::complete_caps(caps);
  const gboolean accepted =
      GST_BASE_TRANSFORM_CLASS(gst_csd_track_dec_parent_class)->accept_caps(trans, direction, complete);
  gst_caps_unref(complete);
  return accepted;
}

/// Updates controlled properties to the frame's stream time.
void gst_csd_track_dec_before_transform(GstBaseTransform *trans, GstBuffer *buffer) {
  csd::sync_properties(trans, trans->segment, buffer);
}

gboolean gst_csd_track_dec_src_event(GstBaseTransform *trans, GstEvent *event) {
  auto *self = GST_CSD_TRACK_DEC(trans);
  guard.logged(self, [&] { self->state->overlay.see_event(event); });
  return GST_BASE_TRANSFORM_CLASS(gst_csd_track_dec_parent_class)->src_event(trans, event);
}

/// GstVideoFilter's set_caps refuses caps that GstVideoInfo can't fully represent.
gboolean gst_csd_track_dec_set_caps(GstBaseTransform *trans, GstCaps *in, GstCaps *out) {
  auto *filter = GST_VIDEO_FILTER(trans);
  return filter->negotiated = csd::read_caps(in, filter->in_info) &&
                              guard.posted(trans, [&] { GST_CSD_TRACK_DEC(trans)->state->overlay.set_caps(in, out); });
}

gboolean gst_csd_track_dec_sink_event(GstBaseTransform *trans, GstEvent *event) {
  auto *self = GST_CSD_TRACK_DEC(trans);
  guard.logged(self, [&] {
    if (GST_EVENT_TYPE(event) == GST_EVENT_STREAM_START) self->state->latency.expire();
    csd::handle_frame_event(self->state->queue, event, GST_BASE_TRANSFORM(self)->segment,
                            live_settings(self).ts_offset);
  });
  return GST_BASE_TRANSFORM_CLASS(gst_csd_track_dec_parent_class)->sink_event(trans, event);
}

/// The base class would query only the video pad.
gboolean gst_csd_track_dec_query(GstBaseTransform *trans, GstPadDirection direction, GstQuery *query) {
  auto *self = GST_CSD_TRACK_DEC(trans);
  if (direction != GST_PAD_SRC || GST_QUERY_TYPE(query) != GST_QUERY_LATENCY)
    return GST_BASE_TRANSFORM_CLASS(gst_csd_track_dec_parent_class)->query(trans, direction, query);
  gboolean answered = FALSE;
  guard.logged(self, [&] {
    bool news = false;
    const auto latency = self->state->latency.tell(GST_BASE_TRANSFORM_SINK_PAD(trans), text_pad(self).get(), news);
    if (latency) gst_query_set_latency(query, latency->live, latency->min, latency->max);
    answered = latency.has_value();
    if (news) self->state->queue.rethink();
  });
  return answered;
}

// ---- The pad text --------------------------------------------------------------------------------------------------

/// Once per stream.
void warn_torn_once(GstCsdTrackDec *self) {
  Text &text = self->state->text;
  const auto dropped = text.lines.take_dropped();
  if (!dropped || std::exchange(text.warned_torn, true)) return;
  GST_ELEMENT_WARNING(self, STREAM, FAILED,
                      ("What came to the pad text broke off in line %" G_GUINT64_FORMAT
                       ": its frame passes without tracks. Look at what brings the text.",
                       dropped->line),
                      ("%s", dropped->why.c_str()));
}

/// Once per stream. The KLV in a transport stream may be the camera's rather than the tracks.
void warn_others_once(GstCsdTrackDec *self) {
  Text &text = self->state->text;
  if (!text.lines.only_others() || std::exchange(text.warned_others, true)) return;
  GST_ELEMENT_WARNING(self, STREAM, WRONG_TYPE,
                      ("Frames pass without tracks: KLV comes to the pad text, but none of it is csdtrackenc's. Link "
                       "another data stream of the demuxer."),
                      (nullptr));
}

void text_begins_anew(GstCsdTrackDec *self) {
  warn_torn_once(self);
  Text &text = self->state->text;
  text.flowing = text.refused = text.warned_torn = text.warned_others = false;
}

GstFlowReturn take_buffer(GstCsdTrackDec *self, GstBuffer *buffer) {
  auto &state = *self->state;
  Text &text = state.text;
  if (state.file) {
    if (!std::exchange(text.warned_unread, true))
      GST_ELEMENT_WARNING(self, RESOURCE, SETTINGS,
                          ("What is linked to the pad text is not read, for location is set. Use one of them."),
                          (nullptr));
    return GST_FLOW_OK;
  }
  if (state.text_unlinked.exchange(false)) {
    text.lines.begin_anew();
    text_begins_anew(self);
  }
  if (!std::exchange(text.flowing, true)) state.latency.expire();
  if (text.refused) return GST_FLOW_ERROR;
  if (text.lines.backwards()) return GST_FLOW_OK;  // frames played backwards don't ask for text
  const csd::MappedBytes mapped(buffer);
  try {
    const bool flowing = text.lines.take(buffer, mapped.bytes(), state.queue);
    warn_torn_once(self);
    warn_others_once(self);
    return flowing ? GST_FLOW_OK : GST_FLOW_FLUSHING;
  } catch (const csd::LineError &error) {
    text.refused = text.warned_torn = true;  // one reason is enough
    throw csd::Refusal(GST_STREAM_ERROR_DECODE,
                       "Line " + std::to_string(text.lines.count() + 1) +
                           " of what came to the pad text: " + error.what() +
                           ". Link what csdtrackenc has written; in a recording that is its text track.");
  }
}

GstFlowReturn gst_csd_track_dec_text_chain(GstPad *, GstObject *parent, GstBuffer *buffer) {
  auto *self = GST_CSD_TRACK_DEC(parent);
  const bool running = self->state->queue.running();
  GstFlowReturn flow = running ? GST_FLOW_ERROR : GST_FLOW_FLUSHING;
  if (running) guard.posted(self, [&] { flow = take_buffer(self, buffer); });
  // Only after posting the error: a waiting frame may be the last, and an application may stop reading the bus at EOS.
  if (running && self->state->text.refused) self->state->queue.end();
  gst_buffer_unref(buffer);
  return flow;
}

/// The text ends here: its events don't go downstream. Events that came before the start are sent again after it.
GstFlowReturn gst_csd_track_dec_text_event(GstPad *, GstObject *parent, GstEvent *event) {
  auto *self = GST_CSD_TRACK_DEC(parent);
  const bool running = self->state->queue.running();
  if (running)
    guard.logged(self, [&] {
      self->state->text.lines.handle(event, self->state->queue);
      if (GST_EVENT_TYPE(event) == GST_EVENT_STREAM_START || GST_EVENT_TYPE(event) == GST_EVENT_EOS)
        text_begins_anew(self);
    });
  gst_event_unref(event);
  return running ? GST_FLOW_OK : GST_FLOW_FLUSHING;
}

/// This pad answers caps queries itself. The default would forward the others to the video's downstream.
gboolean gst_csd_track_dec_text_query(GstPad *pad, GstObject *parent, GstQuery *query) {
  const GstQueryType type = GST_QUERY_TYPE(query);
  return (type == GST_QUERY_CAPS || type == GST_QUERY_ACCEPT_CAPS) && gst_pad_query_default(pad, parent, query);
}

void set_text_linked(GstCsdTrackDec *self, bool linked) {
  guard.logged(self, [&] {
    self->state->queue.set_linked(linked);
    self->state->latency.expire();
  });
}

GstPadLinkReturn gst_csd_track_dec_text_link(GstPad *, GstObject *parent, GstPad *) {
  set_text_linked(GST_CSD_TRACK_DEC(parent), true);
  return GST_PAD_LINK_OK;
}

void gst_csd_track_dec_text_unlink(GstPad *, GstObject *parent) {
  GST_CSD_TRACK_DEC(parent)->state->text_unlinked = true;
  set_text_linked(GST_CSD_TRACK_DEC(parent), false);
}

GstPad *gst_csd_track_dec_request_new_pad(GstElement *element, GstPadTemplate *templ, const gchar *, const GstCaps *) {
  // Pad names are unique in an element: of two simultaneous requests the second gets none.
  GstPad *pad = gst_pad_new_from_template(templ, "text");
  gst_pad_set_chain_function(pad, GST_DEBUG_FUNCPTR(gst_csd_track_dec_text_chain));
  gst_pad_set_event_full_function(pad, GST_DEBUG_FUNCPTR(gst_csd_track_dec_text_event));
  gst_pad_set_query_function(pad, GST_DEBUG_FUNCPTR(gst_csd_track_dec_text_query));
  gst_pad_set_link_function(pad, GST_DEBUG_FUNCPTR(gst_csd_track_dec_text_link));
  gst_pad_set_unlink_function(pad, GST_DEBUG_FUNCPTR(gst_csd_track_dec_text_unlink));
  if (GstPad *other = gst_element_get_static_pad(element, "text")) {
    GST_WARNING_OBJECT(element, "there is one pad text only");
    gst_object_unref(other);
    gst_object_unref(gst_object_ref_sink(pad));
    return nullptr;
  }
  // Becomes active when the element runs or starts. Data that comes earlier is refused.
  return gst_element_add_pad(element, pad) ? pad : nullptr;
}

void gst_csd_track_dec_release_pad(GstElement *element, GstPad *pad) {
  auto *self = GST_CSD_TRACK_DEC(element);
  guard.logged(self, [&] { self->state->queue.flush_lines(true); });
  gst_pad_set_active(pad, FALSE);
  gst_element_remove_pad(element, pad);
  guard.logged(self, [&] { self->state->queue.flush_lines(false); });
}

// ---- GstElement ----------------------------------------------------------------------------------------------------

/// Opens the file named by location; none if it is empty.
bool open_file(GstCsdTrackDec *self, std::unique_ptr<csd::TrackFile> &file) {
  return guard.posted(self, [&] {
    std::string location;
    {
      const csd::ObjectLock lock(self);
      location = self->state->location;
    }
    GST_DEBUG_OBJECT(self, "location is '%s'", location.c_str());
    if (!location.empty()) file = std::make_unique<csd::TrackFile>(location);
  });
}

bool start(GstCsdTrackDec *self) {
  auto &state = *self->state;
  if (!open_file(self, state.file)) return false;
  return guard.posted(self, [&] {
    state.video = {};
    state.text = {};
    state.latency.start();
    {
      const csd::ObjectLock lock(self);
      state.running = true;
    }
    state.queue.start();  // last: after this the text thread reads the state set above
  });
}

/// Runs after the streaming threads have stopped. Waits for the thread of a pad that is being released.
void stop(GstCsdTrackDec *self) {
  if (GstPad *text = gst_element_get_static_pad(GST_ELEMENT(self), "text")) {
    GST_PAD_STREAM_LOCK(text);
    GST_PAD_STREAM_UNLOCK(text);
    gst_object_unref(text);
  }
  self->state->file.reset();
  const csd::ObjectLock lock(self);
  self->state->running = false;
}

/// While paused, the clock doesn't measure how long a frame may wait.
void set_playing(GstCsdTrackDec *self, bool playing) {
  self->state->playing = playing;
  guard.logged(self, [&] { self->state->queue.rethink(); });
}

GstStateChangeReturn gst_csd_track_dec_change_state(GstElement *element, GstStateChange transition) {
  auto *self = GST_CSD_TRACK_DEC(element);
  if (transition == GST_STATE_CHANGE_NULL_TO_READY) {
    std::unique_ptr<csd::TrackFile> unused;  // opened now only to report errors
    if (!open_file(self, unused)) return GST_STATE_CHANGE_FAILURE;
  }
  if (transition == GST_STATE_CHANGE_READY_TO_PAUSED && !start(self)) return GST_STATE_CHANGE_FAILURE;
  if (transition == GST_STATE_CHANGE_PAUSED_TO_READY) guard.logged(self, [&] { self->state->queue.stop(); });
  if (transition == GST_STATE_CHANGE_PLAYING_TO_PAUSED) set_playing(self, false);
  const auto result = GST_ELEMENT_CLASS(gst_csd_track_dec_parent_class)->change_state(element, transition);
  if (transition == GST_STATE_CHANGE_PAUSED_TO_PLAYING && result != GST_STATE_CHANGE_FAILURE) set_playing(self, true);
  if (transition == GST_STATE_CHANGE_READY_TO_PAUSED && result == GST_STATE_CHANGE_FAILURE)
    guard.logged(self, [&] { self->state->queue.stop(); });
  if (transition == GST_STATE_CHANGE_PAUSED_TO_READY ||
      (transition == GST_STATE_CHANGE_READY_TO_PAUSED && result == GST_STATE_CHANGE_FAILURE))
    guard.logged(self, [&] { stop(self); });
  return result;
}

// ---- GObject -------------------------------------------------------------------------------------------------------

void gst_csd_track_dec_set_property(GObject *object, guint id, const GValue *value, GParamSpec *spec) {
  auto *self = GST_CSD_TRACK_DEC(object);
  auto &state = *self->state;
  bool refused = false;
  guard.logged(self, [&] {
    const csd::ObjectLock lock(self);
    switch (id) {
      case prop_location:
        refused = state.running;
        if (!refused) state.location = g_value_get_string(value) ? g_value_get_string(value) : "";
        break;
      case prop_overlay:
        state.live.overlay = static_cast<GstCsdTrackOverlay>(g_value_get_enum(value));
        break;
      case prop_max_wait:
        state.live.max_wait = g_value_get_uint64(value);
        break;
      case prop_ts_offset:
        state.live.ts_offset = g_value_get_int64(value);
        break;
      case prop_min_upstream_latency:
        state.latency.set_least(g_value_get_uint64(value));
        break;
      default:
        G_OBJECT_WARN_INVALID_PROPERTY_ID(object, id, spec);
    }
  });
  // Not under the object lock: the negotiation has its own. A controller sets this property on every frame.
  if (id == prop_overlay) guard.logged(self, [&] { state.overlay.see_value(state.live.overlay); });
  if (refused) GST_WARNING_OBJECT(self, "%s can be set in NULL and READY only: it stays as it was", spec->name);
}

void gst_csd_track_dec_get_property(GObject *object, guint id, GValue *value, GParamSpec *spec) {
  auto *self = GST_CSD_TRACK_DEC(object);
  auto &state = *self->state;
  guard.logged(self, [&] {
    const csd::ObjectLock lock(self);
    switch (id) {
      case prop_location:
        g_value_set_string(value, state.location.c_str());
        break;
      case prop_overlay:
        g_value_set_enum(value, state.live.overlay);
        break;
      case prop_max_wait:
        g_value_set_uint64(value, state.live.max_wait);
        break;
      case prop_ts_offset:
        g_value_set_int64(value, state.live.ts_offset);
        break;
      case prop_min_upstream_latency:
        g_value_set_uint64(value, state.latency.least());
        break;
      default:
        G_OBJECT_WARN_INVALID_PROPERTY_ID(object, id, spec);
    }
  });
}

void gst_csd_track_dec_finalize(GObject *object) {
  delete GST_CSD_TRACK_DEC(object)->state;
  G_OBJECT_CLASS(gst_csd_track_dec_parent_class)->finalize(object);
}

void add_pad_templates(GstElementClass *klass) {
  GstCaps *caps = csd::any_memory_caps();
  gst_element_class_add_pad_template(klass, gst_pad_template_new("sink", GST_PAD_SINK, GST_PAD_ALWAYS, caps));
  gst_element_class_add_pad_template(klass, gst_pad_template_new("src", GST_PAD_SRC, GST_PAD_ALWAYS, caps));
  gst_caps_unref(caps);
  gst_element_class_add_static_pad_template(klass, &text_template);
}

}  // namespace

static void gst_csd_track_dec_class_init(GstCsdTrackDecClass *klass) {
  auto *object_class = G_OBJECT_CLASS(klass);
  auto *element_class = GST_ELEMENT_CLASS(klass);
  auto *trans_class = GST_BASE_TRANSFORM_CLASS(klass);

  object_class->set_property = gst_csd_track_dec_set_property;
  object_class->get_property = gst_csd_track_dec_get_property;
  object_class->finalize = gst_csd_track_dec_finalize;
  /**
   * GstCsdTrackDec:location:
   *
   * A file of JSON lines (.jsonl) that csdtrackenc wrote. It is read along with the frames and follows seeks. Data on
   * the pad `text` is then ignored.
   *
   * Since: 0.1
   */
  g_object_class_install_property(
      object_class, prop_location,
      g_param_spec_string(
          "location", "Location", "File of JSON lines from csdtrackenc (empty = lines arrive on the pad text)", "",
          static_cast<GParamFlags>(G_PARAM_READWRITE | G_PARAM_STATIC_STRINGS | GST_PARAM_MUTABLE_READY)));
  /**
   * GstCsdTrackDec:overlay:
   *
   * How tracks are shown: drawn into the pixels, or as a #GstVideoOverlayComposition beside them. If downstream can't
   * show the latter, the element posts one WARNING and leaves the pixels as they are.
   *
   * Since: 0.1
   */
  g_object_class_install_property(object_class, prop_overlay, csd::Overlay::param_spec());
  /**
   * GstCsdTrackDec:max-wait:
   *
   * A frame waits until the pad `text` has brought its line, a later one, a GAP or EOS. After this time it goes on
   * without tracks, the element posts one WARNING, and no frame waits until text is in time again. Live, every frame
   * waits, but no longer than the latency in the answer to the LATENCY query.
   *
   * Since: 0.1
   */
  g_object_class_install_property(
      object_class, prop_max_wait,
      g_param_spec_uint64(
          "max-wait", "Maximum wait",
          "How many nanoseconds a frame waits for its line from the pad text before it goes on without (0 = it never "
          "waits)",
          0, G_MAXINT64, default_max_wait,
          static_cast<GParamFlags>(G_PARAM_READWRITE | G_PARAM_STATIC_STRINGS | GST_PARAM_MUTABLE_PLAYING)));
  /**
   * GstCsdTrackDec:ts-offset:
   *
   * Added to the time of each line. Use it when a part of a recording plays on its own from 0, while its lines have the
   * time of the whole: set it to minus the time at which the part begins.
   *
   * Since: 0.1
   */
  g_object_class_install_property(
      object_class, prop_ts_offset,
      g_param_spec_int64(
          "ts-offset", "Timestamp offset", "Nanoseconds to add to the time of each line", -max_offset, max_offset, 0,
          static_cast<GParamFlags>(G_PARAM_READWRITE | G_PARAM_STATIC_STRINGS | GST_PARAM_MUTABLE_PLAYING)));

  /**
   * GstCsdTrackDec:min-upstream-latency:
   *
   * Like GstAggregator's: live, the latency is at least this, even if both upstreams report less. For text that comes
   * later than that, or a branch linked while the pipeline plays.
   *
   * Since: 0.1
   */
  g_object_class_install_property(
      object_class, prop_min_upstream_latency,
      g_param_spec_uint64(
          "min-upstream-latency", "Minimum upstream latency",
          "Minimum upstream latency to assume for live streams, in nanoseconds, even if upstream reports less", 0,
          G_MAXINT64, 0,
          static_cast<GParamFlags>(G_PARAM_READWRITE | G_PARAM_STATIC_STRINGS | GST_PARAM_MUTABLE_PLAYING)));

  gst_element_class_set_static_metadata(element_class, "Track decoder", "Filter/Metadata/Video",
                                        "Puts recorded tracks back on video frames, and shows them if wanted",
                                        "The csdtrack authors");
  add_pad_templates(element_class);
  element_class->change_state = GST_DEBUG_FUNCPTR(gst_csd_track_dec_change_state);
  element_class->request_new_pad = GST_DEBUG_FUNCPTR(gst_csd_track_dec_request_new_pad);
  element_class->release_pad = GST_DEBUG_FUNCPTR(gst_csd_track_dec_release_pad);

  // GstVideoFilter's transform_ip maps read-write, which copies every frame's pixels behind a tee.
  trans_class->transform_ip = GST_DEBUG_FUNCPTR(gst_csd_track_dec_transform_ip);
  trans_class->before_transform = GST_DEBUG_FUNCPTR(gst_csd_track_dec_before_transform);
  trans_class->sink_event = GST_DEBUG_FUNCPTR(gst_csd_track_dec_sink_event);
  trans_class->query = GST_DEBUG_FUNCPTR(gst_csd_track_dec_query);
  trans_class->src_event = GST_DEBUG_FUNCPTR(gst_csd_track_dec_src_event);
  trans_class->transform_caps = GST_DEBUG_FUNCPTR(gst_csd_track_dec_transform_caps);
  trans_class->fixate_caps = GST_DEBUG_FUNCPTR(gst_csd_track_dec_fixate_caps);
  trans_class->accept_caps = GST_DEBUG_FUNCPTR(gst_csd_track_dec_accept_caps);
  trans_class->set_caps = GST_DEBUG_FUNCPTR(gst_csd_track_dec_set_caps);
}

static void gst_csd_track_dec_init(GstCsdTrackDec *self) {
  auto *trans = GST_BASE_TRANSFORM(self);
  self->state = new GstCsdTrackDecState(trans);
  gst_base_transform_set_in_place(trans, TRUE);
  gst_base_transform_set_gap_aware(trans, TRUE);
  // Otherwise the base class tries the input's caps first and never offers the feature that overlay=meta needs.
  gst_base_transform_set_prefer_passthrough(trans, FALSE);
  // GstVideoFilter turns it on, which drops late frames before they get here and leaves a hole in a recording.
  gst_base_transform_set_qos_enabled(trans, FALSE);
}
