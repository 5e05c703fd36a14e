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
 * recording's text track, or KLV, as from MPEG-TS and RTP. A line that came in a buffer with a timestamp belongs to
 * that running time, as a subtitle does; a line of a file, or of a byte stream without timestamps, to its own stream
 * time. A frame gets the nearest line, at most half a frame away. Positions are scaled from the line's picture to the
 * frame's. Live, the latency covers both pads, and no frame waits longer for its line.
 *
 * The element is a #GstAggregator: it pushes frames from a thread of its own.
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
#include <mutex>
#include <optional>
#include <string>
#include <utility>

#include "caps/frame_mapping.h"
#include "caps/frame_time.h"
#include "meta/meta.h"
#include "overlay/overlay.h"
#include "record/attach_line.h"
#include "record/frame_lines.h"
#include "record/track_file.h"
#include "record/video_stream.h"
#include "support/dec_properties.h"
#include "support/frame_wait.h"
#include "support/guard.h"
#include "support/lock.h"
#include "support/pads.h"
#include "support/queued_events.h"

GST_DEBUG_CATEGORY_STATIC(gst_csd_track_dec_debug);
#define GST_CAT_DEFAULT gst_csd_track_dec_debug

namespace {

void wake(GstElement *element);

const csd::Guard guard(gst_csd_track_dec_debug,
                       "Out of memory for recorded tracks. Use overlay=none, or smaller pictures.",
                       "Recorded tracks could not be put on a frame", "Use overlay=none, or smaller pictures.");

}  // namespace

/// The C++ members, with destructors.
struct GstCsdTrackDecState {
  GstCsdTrackDecState(GstElement *element, GstPad *sink)
      : overlay(element, sink, GST_AGGREGATOR_SRC_PAD(element)),
        wait(element, wake),
        lines(element, guard),
        base_chain(GST_PAD_CHAINFUNC(sink)) {}

  // Guarded by the object lock, held only for a copy.
  csd::DecValues values;
  bool running = false;  ///< since READY→PAUSED; location is then read-only

  csd::Overlay overlay;   ///< documents which thread may call what
  csd::FrameWait wait;    ///< thread-safe
  csd::FrameLines lines;  ///< documents which thread may call what
  csd::VideoStream video;
  const GstPadChainFunction base_chain;  ///< of the base class's pads

  std::recursive_mutex frame_mutex;  ///< held while a frame is handled and pushed; a flush ends only in between
  std::mutex text_mutex;             ///< held by a flush of the text, and while one of its events takes effect
  /// What downstream said of the last frame. The base class would stop for good if it heard of it.
  std::atomic<GstFlowReturn> flow = GST_FLOW_OK;
  std::atomic<bool> video_ended = false;   ///< by EOS: the text flows on, unread
  std::atomic<bool> seeking = false;       ///< a flushing seek is under way: frames wait for both pads' flush
  std::atomic<bool> text_flushed = false;  ///< since the seek began
  std::atomic<bool> flushing = false;      ///< the video, from FLUSH_START to FLUSH_STOP
  std::atomic<std::uint64_t> flushes = 0;  ///< of the video
  csd::QueuedEvents video_events, text_events;
};

struct _GstCsdTrackDec {
  GstAggregator parent;
  GstCsdTrackDecState *state;
};

G_DEFINE_TYPE_WITH_CODE(GstCsdTrackDec, gst_csd_track_dec, GST_TYPE_AGGREGATOR,
                        GST_DEBUG_CATEGORY_INIT(gst_csd_track_dec_debug, "csdtrackdec", 0, "recorded tracks"))
GST_ELEMENT_REGISTER_DEFINE_WITH_CODE(csdtrackdec, "csdtrackdec", GST_RANK_NONE, GST_TYPE_CSD_TRACK_DEC,
                                      csd::register_track_metas())

namespace {

using csd::PadPtr, csd::pad_named;

csd::DecLive live_of(GstCsdTrackDec *self) {
  const csd::ObjectLock lock(self);
  return self->state->values.live;
}

constexpr auto is_text = csd::is_request_pad;

/// Lets the base class handle an event.
gboolean base_event(GstCsdTrackDec *self, GstAggregatorPad *pad, GstEvent *event) {
  return GST_AGGREGATOR_CLASS(gst_csd_track_dec_parent_class)->sink_event(GST_AGGREGATOR(self), pad, event);
}

GstFlowReturn base_pre_queue(GstCsdTrackDec *self, GstAggregatorPad *pad, GstEvent *event) {
  return GST_AGGREGATOR_CLASS(gst_csd_track_dec_parent_class)->sink_event_pre_queue(GST_AGGREGATOR(self), pad, event);
}

bool is_flush(GstEvent *event) {
  return GST_EVENT_TYPE(event) == GST_EVENT_FLUSH_START || GST_EVENT_TYPE(event) == GST_EVENT_FLUSH_STOP;
}

/// Whether no frame can go on. A link may still come.
bool is_final(GstFlowReturn flow) {
  return flow != GST_FLOW_OK && flow != GST_FLOW_NOT_LINKED;
}

// ---- How long a frame waits ----------------------------------------------------------------------------------------
//
// The base class calls aggregate() once each pad has a buffer, or has ended; live, at the latest when the frame is due.
// Not live, it would wait for ever, and so it would for a pad that isn't linked. A wake tells it that the text has
// ended; aggregate() takes that back. It gets through while the text is being flushed, when the pad takes no events.

/// From any thread, also the system clock's: the base class holds its lock only for moments, and not while it waits,
/// pushes or queries.
void wake(GstElement *element) {
  auto *self = GST_CSD_TRACK_DEC(element);
  if (const PadPtr text = pad_named(self, "text")) base_event(self, text.get(), gst_event_new_eos());
}

void take_wake(GstCsdTrackDec *self, GstAggregatorPad *text) {
  if (gst_aggregator_pad_is_eos(text) && !self->state->lines.text_ended())
    base_event(self, text, gst_event_new_stream_start("text"));
}

/// Called when a buffer comes to the head of its pad's queue. The base class holds the pad's lock, which it takes
/// within the object lock: so this must not take that.
GstBuffer *gst_csd_track_dec_clip(GstAggregator *aggregator, GstAggregatorPad *pad, GstBuffer *buffer) {
  auto *self = GST_CSD_TRACK_DEC(aggregator);
  if (is_text(pad)) return buffer;
  auto &state = *self->state;
  state.video.head =
      csd::frame_moments(pad->segment, state.video.info, buffer, state.video.pace.next(GST_BUFFER_PTS(buffer)));
  return buffer;
}

/// When the next frame is due, without the latency. Called with the base class's lock held, whenever it is about to
/// wait.
GstClockTime gst_csd_track_dec_get_next_time(GstAggregator *aggregator) {
  auto *self = GST_CSD_TRACK_DEC(aggregator);
  auto &state = *self->state;
  const PadPtr video = pad_named(self, "sink"), text = pad_named(self, "text");
  const bool final = is_final(state.flow);
  if (!gst_aggregator_pad_has_buffer(video.get())) {
    // Nothing reads the text any more, and its thread must not wait for room.
    while (text && (state.video_ended || final) && gst_aggregator_pad_drop_buffer(text.get())) continue;
    return GST_CLOCK_TIME_NONE;
  }
  if (text)
    guard.logged(self, [&] {
      state.lines.frame(csd::shifted(state.video.head, live_of(self).ts_offset));
      if (final || state.lines.need_not_wait())
        state.wait.look_again();
      else
        state.wait.begin(live_of(self).max_wait);
    });
  const auto &running = state.video.head.running;
  return running ? static_cast<GstClockTime>(std::max<std::int64_t>(running->time, 0)) : GST_CLOCK_TIME_NONE;
}

// ---- A frame -------------------------------------------------------------------------------------------------------

/// A frame that a flush drops is no failure.
void push_frame(GstCsdTrackDec *self, GstBuffer *buffer) {
  auto &state = *self->state;
  GstPad *src = GST_AGGREGATOR_SRC_PAD(self);
  const std::uint64_t flushes = state.flushes;
  const GstFlowReturn flow = gst_pad_push(src, buffer);
  if (flushes == state.flushes && (flow != GST_FLOW_FLUSHING || !GST_PAD_IS_FLUSHING(src))) state.flow = flow;
}

GstFlowReturn handle_frame(GstCsdTrackDec *self, GstBuffer *buffer, std::optional<csd::TrackLine> &line) {
  auto &state = *self->state;
  const GstCsdTrackOverlay overlay = live_of(self).overlay;
  if (!state.overlay.can_show(overlay)) return GST_FLOW_NOT_NEGOTIATED;
  const bool done = guard.posted(self, [&] {
    state.overlay.settle(overlay);
    GST_LOG_OBJECT(self, "frame at %" GST_TIME_FORMAT ": %s", GST_TIME_ARGS(GST_BUFFER_PTS(buffer)),
                   line ? "its line" : "no line");
    if (!line || !line->numbered) return;  // the frame had no tracks when recorded
    auto &video = state.video;
    if (csd::attach_line(GST_ELEMENT(self), buffer, video.info, *line, video.warned_aspect))
      state.overlay.show(video.info, buffer, line->tracks, overlay);
  });
  return done ? GST_FLOW_OK : GST_FLOW_ERROR;
}

/// The frame at the head of the video's queue: handles it, or leaves it there while its line isn't known.
GstFlowReturn gst_csd_track_dec_aggregate(GstAggregator *aggregator, gboolean timeout) {
  auto *self = GST_CSD_TRACK_DEC(aggregator);
  auto &state = *self->state;
  if (state.seeking) {
    g_usleep(1000);  // the base class asks again at once
    return GST_AGGREGATOR_FLOW_NEED_DATA;
  }
  const std::lock_guard lock(state.frame_mutex);
  const PadPtr video = pad_named(self, "sink"), text = pad_named(self, "text");
  if (text) take_wake(self, text.get());
  if (!gst_aggregator_pad_has_buffer(video.get())) return GST_AGGREGATOR_FLOW_NEED_DATA;
  std::optional<csd::TrackLine> line;
  bool known = true;
  const bool read = guard.posted(self, [&] {
    if (is_final(state.flow)) return;  // upstream hears of it with its next frame
    state.lines.frame(csd::shifted(state.video.head, live_of(self).ts_offset));
    known = state.lines.find(text.get(), {timeout != FALSE, state.wait.over(), live_of(self).max_wait}, line);
  });
  if (!known) return GST_AGGREGATOR_FLOW_NEED_DATA;
  state.wait.next();
  GstBuffer *buffer = gst_aggregator_pad_pop_buffer(video.get());
  if (!buffer) return GST_AGGREGATOR_FLOW_NEED_DATA;  // flushed meanwhile
  csd::sync_properties(self, video->segment, buffer);
  buffer = gst_buffer_make_writable(buffer);  // the memory is not copied
  GstFlowReturn flow = is_final(state.flow) ? state.flow.load() : read ? GST_FLOW_OK : GST_FLOW_ERROR;
  if (flow == GST_FLOW_OK && !state.video.negotiated) {
    GST_ELEMENT_ERROR(self, CORE, NEGOTIATION, (nullptr),
                      ("%s", state.video.caps ? "downstream doesn't take the video" : "a buffer came before its caps"));
    flow = GST_FLOW_NOT_NEGOTIATED;
  }
  if (flow == GST_FLOW_OK) flow = handle_frame(self, buffer, line);
  if (flow == GST_FLOW_OK) {
    push_frame(self, buffer);
  } else {
    state.flow = flow;
    gst_buffer_unref(buffer);
  }
  return GST_FLOW_OK;
}

/// Between what came over the old link, some of which may still be in the queue, and what comes over the new one.
void mark_new_link(GstCsdTrackDec *self, GstAggregatorPad *text) {
  if (GstEvent *mark = self->state->lines.take_relinked())
    GST_AGGREGATOR_GET_CLASS(self)->sink_event_pre_queue(GST_AGGREGATOR(self), text, mark);
}

/// Upstream hears what downstream said of the frame before, unless another stream or segment has begun since.
GstFlowReturn gst_csd_track_dec_chain(GstPad *pad, GstObject *parent, GstBuffer *buffer) {
  auto &state = *GST_CSD_TRACK_DEC(parent)->state;
  const bool text = is_text(GST_AGGREGATOR_PAD(pad));
  const bool anew = state.video_events.begin_anew();  // first: then the flow is of what has begun
  const GstFlowReturn flow = anew ? GST_FLOW_OK : state.flow.load();
  if (text) mark_new_link(GST_CSD_TRACK_DEC(parent), GST_AGGREGATOR_PAD(pad));
  if (!is_final(flow) && !(text && (state.video_ended || state.lines.leave_text()))) {
    const GstFlowReturn queued = state.base_chain(pad, parent, buffer);
    return text || queued != GST_FLOW_OK ? queued : flow;
  }
  gst_buffer_unref(buffer);
  return text ? GST_FLOW_OK : flow;
}

// ---- Caps ----------------------------------------------------------------------------------------------------------

/// Called when downstream has changed, and for new caps of the video.
gboolean gst_csd_track_dec_negotiate(GstAggregator *aggregator) {
  auto *self = GST_CSD_TRACK_DEC(aggregator);
  auto &state = *self->state;
  if (!state.video.caps) return TRUE;
  bool negotiated = false;
  const bool posted = !guard.posted(self, [&] {
    GstCaps *caps = state.overlay.choose_caps(state.video.caps);
    if (!gst_caps_is_empty(caps)) {
      GstPad *src = GST_AGGREGATOR_SRC_PAD(self);
      GstCaps *current = gst_pad_get_current_caps(src);
      // An unlinked pad keeps the event. The first push reports that it isn't linked.
      negotiated = (current && gst_caps_is_equal(current, caps)) || gst_pad_push_event(src, gst_event_new_caps(caps)) ||
                   !gst_pad_is_linked(src) || GST_PAD_IS_FLUSHING(src);
      gst_clear_caps(&current);
      if (negotiated) state.overlay.set_caps(state.video.caps, caps);
    }
    gst_caps_unref(caps);
  });
  if (posted) state.flow = GST_FLOW_ERROR;  // one error is enough
  state.video.negotiated = negotiated;
  return TRUE;  // the base class would stop for good, and say nothing: the next frame reports it
}

bool set_caps(GstCsdTrackDec *self, GstCaps *caps) {
  auto &video = self->state->video;
  video.begin(caps);
  return csd::read_caps(caps, video.info) && gst_aggregator_negotiate(GST_AGGREGATOR(self)) && video.negotiated;
}

// ---- Events --------------------------------------------------------------------------------------------------------

/// What comes next may be wanted again.
void forget_eos(GstCsdTrackDec *self) {
  GstFlowReturn eos = GST_FLOW_EOS;
  self->state->flow.compare_exchange_strong(eos, GST_FLOW_OK);
}

/// The video's serialized events go downstream in order with its frames. The base class would make up its own.
gboolean handle_video_event(GstCsdTrackDec *self, GstAggregatorPad *pad, GstEvent *event) {
  auto &state = *self->state;
  const std::lock_guard between_flushes(state.frame_mutex);
  if (GST_EVENT_TYPE(event) == GST_EVENT_STREAM_START || GST_EVENT_TYPE(event) == GST_EVENT_SEGMENT) forget_eos(self);
  if (!state.video_events.take(event)) {
    gst_event_unref(event);
    return TRUE;
  }
  switch (GST_EVENT_TYPE(event)) {
    case GST_EVENT_CAPS: {
      GstCaps *caps = nullptr;
      gst_event_parse_caps(event, &caps);
      const bool set = set_caps(self, caps);
      gst_event_unref(event);
      return set;
    }
    case GST_EVENT_STREAM_START: {
      const gchar *id = nullptr;
      gst_event_parse_stream_start(event, &id);
      state.lines.frames_begin(id);
      state.video_ended = false;
      break;
    }
    case GST_EVENT_SEGMENT:
      state.lines.frames_begin(nullptr);
      state.video_ended = false;
      // The base class measures the queue by it.
      base_event(self, pad, gst_event_ref(event));
      break;
    case GST_EVENT_GAP: {
      // The text goes along, as far as it is there.
      const PadPtr text = pad_named(self, "text");
      state.lines.skip(text.get(), csd::shifted(csd::gap_moments(pad->segment, event), live_of(self).ts_offset));
      break;
    }
    case GST_EVENT_EOS:
      state.video_ended = true;
      break;
    default:
      break;
  }
  return gst_pad_push_event(GST_AGGREGATOR_SRC_PAD(self), event);
}

/// The text ends here: its events don't go downstream.
gboolean handle_text_event(GstCsdTrackDec *self, GstAggregatorPad *pad, GstEvent *event) {
  auto &state = *self->state;
  std::unique_lock<std::mutex> between_flushes(state.text_mutex);
  if (!state.text_events.take(event)) {
    gst_event_unref(event);
    return TRUE;
  }
  const auto notices = state.lines.text_event(event);
  gboolean done = TRUE;
  if (GST_EVENT_TYPE(event) == GST_EVENT_STREAM_START || GST_EVENT_TYPE(event) == GST_EVENT_EOS) {
    done = base_event(self, pad, event);
    state.wait.begin_anew();  // this may have undone a wake: the frame begins to wait again
  } else {
    // A segment not by the base class: it would give the text's sequence number to the video.
    const csd::ObjectLock lock(pad);
    if (GST_EVENT_TYPE(event) == GST_EVENT_SEGMENT) gst_event_copy_segment(event, &pad->segment);
    gst_event_unref(event);
  }
  between_flushes.unlock();
  csd::PadLines::post(GST_ELEMENT(self), notices);
  return done;
}

/// A flush of the video goes downstream, also one of the video alone, which the base class keeps to itself.
GstFlowReturn flush_video(GstCsdTrackDec *self, GstAggregatorPad *pad, GstEvent *event) {
  auto &state = *self->state;
  GstPad *src = GST_AGGREGATOR_SRC_PAD(self);
  const bool start = GST_EVENT_TYPE(event) == GST_EVENT_FLUSH_START;
  std::unique_lock<std::recursive_mutex> between_frames(state.frame_mutex, std::defer_lock);
  state.flushing = true;
  if (start) {
    ++state.flushes;
  } else {
    between_frames.lock();
    gst_aggregator_pad_drop_buffer(pad);  // one that the base class has looked at before
    state.wait.next();
    state.lines.flush_frames();
    state.flow = GST_FLOW_OK;
    state.video_ended = false;
  }
  state.video_events.flush();
  const GstFlowReturn flow = base_pre_queue(self, pad, gst_event_ref(event));
  if (!start) state.flushing = false;
  if ((GST_PAD_IS_FLUSHING(src) != 0) == start)
    gst_event_unref(event);
  else
    gst_pad_push_event(src, event);
  return flow;
}

/// A flush of the text stays here. With the video's sequence number, the base class would flush everything.
GstFlowReturn flush_text(GstCsdTrackDec *self, GstAggregatorPad *pad, GstEvent *event) {
  auto &state = *self->state;
  gboolean reset = TRUE;
  const bool start = GST_EVENT_TYPE(event) == GST_EVENT_FLUSH_START;
  if (!start) gst_event_parse_flush_stop(event, &reset);
  gst_event_unref(event);
  std::unique_lock<std::mutex> lock(state.text_mutex);
  state.text_events.flush();
  const GstFlowReturn flow =
      base_pre_queue(self, pad, start ? gst_event_new_flush_start() : gst_event_new_flush_stop(reset));
  state.lines.flush_text();
  lock.unlock();
  state.text_flushed = true;
  if (!start) {  // this may have undone a wake
    state.wait.begin_anew();
    wake(GST_ELEMENT(self));
  }
  return flow;
}

/// Before an event waits in the queue. A flush takes effect here: from GStreamer 1.30 on, sink_event() hears of few
/// FLUSH_STOPs.
GstFlowReturn gst_csd_track_dec_sink_event_pre_queue(GstAggregator *aggregator, GstAggregatorPad *pad,
                                                     GstEvent *event) {
  auto *self = GST_CSD_TRACK_DEC(aggregator);
  if (is_text(pad)) mark_new_link(self, pad);
  GstFlowReturn flow = GST_FLOW_ERROR;
  if (is_flush(event)) {
    guard.logged(self, [&] { flow = (is_text(pad) ? flush_text : flush_video)(self, pad, event); });
    return flow;
  }
  auto &queued = is_text(pad) ? self->state->text_events : self->state->video_events;
  queued.add(event);
  flow = base_pre_queue(self, pad, event);
  if (flow != GST_FLOW_OK) queued.remove(event);
  return flow;
}

/// The base class's part of a flush.
gboolean handle_flush(GstCsdTrackDec *self, GstAggregatorPad *pad, GstEvent *event) {
  if (is_text(pad) || GST_EVENT_TYPE(event) == GST_EVENT_FLUSH_START) return base_event(self, pad, event);
  // GStreamer 1.30 queues it for its own thread, and then it has gone downstream.
  const std::lock_guard between_frames(self->state->frame_mutex);
  if (self->state->flushing) return base_event(self, pad, event);
  gst_event_unref(event);
  return TRUE;
}

gboolean gst_csd_track_dec_sink_event(GstAggregator *aggregator, GstAggregatorPad *pad, GstEvent *event) {
  auto *self = GST_CSD_TRACK_DEC(aggregator);
  const auto handle = is_flush(event) ? handle_flush : is_text(pad) ? handle_text_event : handle_video_event;
  gboolean done = FALSE;
  guard.logged(self, [&] { done = handle(self, pad, event); });
  return done;
}

/// Sends a seek to both pads. Frames wait until both have been flushed: they must not find the old text.
bool seek(GstCsdTrackDec *self, GstPad *video, GstPad *text, GstEvent *event) {
  auto &state = *self->state;
  GstSeekFlags flags = GST_SEEK_FLAG_NONE;
  gst_event_parse_seek(event, nullptr, nullptr, &flags, nullptr, nullptr, nullptr, nullptr);
  state.text_flushed = false;
  // Without a flush the source may wait for us to take a frame.
  state.seeking = (flags & GST_SEEK_FLAG_FLUSH) != 0;
  const bool sought = gst_pad_push_event(video, gst_event_ref(event)) != FALSE;
  // A demuxer of both has flushed the text already.
  if (sought && text && !state.text_flushed) gst_pad_push_event(text, gst_event_ref(event));
  gst_event_unref(event);
  if (state.seeking.exchange(false)) wake(GST_ELEMENT(self));
  return sought;
}

/// To both pads, as GStreamer's text overlay does.
gboolean gst_csd_track_dec_src_event(GstAggregator *aggregator, GstEvent *event) {
  auto *self = GST_CSD_TRACK_DEC(aggregator);
  guard.logged(self, [&] { self->state->overlay.see_event(event); });
  const PadPtr video = pad_named(self, "sink"), text = pad_named(self, "text");
  if (GST_EVENT_TYPE(event) == GST_EVENT_RECONFIGURE) forget_eos(self);  // another link
  if (GST_EVENT_TYPE(event) == GST_EVENT_SEEK) return seek(self, GST_PAD(video.get()), GST_PAD(text.get()), event);
  if (text) gst_pad_push_event(GST_PAD(text.get()), gst_event_ref(event));
  return gst_pad_push_event(GST_PAD(video.get()), event);
}

// ---- Queries -------------------------------------------------------------------------------------------------------

gboolean gst_csd_track_dec_sink_query(GstAggregator *aggregator, GstAggregatorPad *pad, GstQuery *query) {
  auto *self = GST_CSD_TRACK_DEC(aggregator);
  const GstQueryType type = GST_QUERY_TYPE(query);
  // The default would forward the text's queries to the video's downstream.
  if (is_text(pad))
    return (type == GST_QUERY_CAPS || type == GST_QUERY_ACCEPT_CAPS) &&
           gst_pad_query_default(GST_PAD(pad), GST_OBJECT(self), query);
  if (type != GST_QUERY_CAPS && type != GST_QUERY_ACCEPT_CAPS)
    return gst_pad_peer_query(GST_AGGREGATOR_SRC_PAD(self), query);
  return guard.logged(self, [&] { self->state->overlay.answer_caps(GST_PAD_SINK, query); });
}

gboolean gst_csd_track_dec_src_query(GstAggregator *aggregator, GstQuery *query) {
  auto *self = GST_CSD_TRACK_DEC(aggregator);
  switch (GST_QUERY_TYPE(query)) {
    case GST_QUERY_LATENCY:
    case GST_QUERY_SCHEDULING:  // nobody can pull from a thread of our own
      return GST_AGGREGATOR_CLASS(gst_csd_track_dec_parent_class)->src_query(aggregator, query);
    case GST_QUERY_CAPS:
    case GST_QUERY_ACCEPT_CAPS:
      return guard.logged(self, [&] { self->state->overlay.answer_caps(GST_PAD_SRC, query); });
    default: {
      const PadPtr video = pad_named(self, "sink");
      return gst_pad_peer_query(GST_PAD(video.get()), query);
    }
  }
}

// ---- The pad text --------------------------------------------------------------------------------------------------

GstPadLinkReturn gst_csd_track_dec_text_link(GstPad *, GstObject *parent, GstPad *) {
  GST_CSD_TRACK_DEC(parent)->state->lines.set_linked(true);
  return GST_PAD_LINK_OK;
}

/// Nothing will come: a frame that waits goes on. Not at once, as GStreamer holds the pad's lock here.
void gst_csd_track_dec_text_unlink(GstPad *pad, GstObject *parent) {
  auto &state = *GST_CSD_TRACK_DEC(parent)->state;
  state.lines.set_linked(false);
  if (GST_PAD_IS_ACTIVE(pad)) guard.logged(parent, [&] { state.wait.look_again(); });
}

GstAggregatorPad *gst_csd_track_dec_create_new_pad(GstAggregator *aggregator, GstPadTemplate *templ, const gchar *,
                                                   const GstCaps *) {
  if (pad_named(GST_CSD_TRACK_DEC(aggregator), "text")) {
    GST_WARNING_OBJECT(aggregator, "there is one pad text only");
    return nullptr;
  }
  // The base class would wait for a FLUSH_STOP on it, too, before it goes on.
  if (GST_CSD_TRACK_DEC(aggregator)->state->flushing) {
    GST_WARNING_OBJECT(aggregator, "no pad can be added while the video is being flushed");
    return nullptr;
  }
  auto *pad = GST_AGGREGATOR_PAD(
      g_object_new(GST_TYPE_AGGREGATOR_PAD, "name", "text", "direction", GST_PAD_SINK, "template", templ, nullptr));
  gst_pad_set_chain_function(GST_PAD(pad), GST_DEBUG_FUNCPTR(gst_csd_track_dec_chain));
  gst_pad_set_link_function(GST_PAD(pad), GST_DEBUG_FUNCPTR(gst_csd_track_dec_text_link));
  gst_pad_set_unlink_function(GST_PAD(pad), GST_DEBUG_FUNCPTR(gst_csd_track_dec_text_unlink));
  return pad;
}

void gst_csd_track_dec_release_pad(GstElement *element, GstPad *pad) {
  auto *self = GST_CSD_TRACK_DEC(element);
  GST_ELEMENT_CLASS(gst_csd_track_dec_parent_class)->release_pad(element, pad);
  self->state->text_events.clear();
  guard.logged(self, [&] { self->state->lines.flush_text(); });
}

// ---- States --------------------------------------------------------------------------------------------------------

/// Opens the file named by location; none if it is empty.
bool open_file(GstCsdTrackDec *self, std::unique_ptr<csd::TrackFile> &file) {
  return guard.posted(self, [&] {
    std::string location;
    {
      const csd::ObjectLock lock(self);
      location = self->state->values.location;
    }
    if (!location.empty()) file = std::make_unique<csd::TrackFile>(location);
  });
}

/// Before the element's thread starts, or after it has stopped.
void start_anew(GstCsdTrackDec *self, std::unique_ptr<csd::TrackFile> file) {
  auto &state = *self->state;
  state.wait.stop();
  gst_clear_caps(&state.video.caps);
  state.video = {};
  state.flow = GST_FLOW_OK;
  state.video_ended = state.flushing = false;
  state.video_events.clear();
  state.text_events.clear();
  state.lines.start(std::move(file));
}

gboolean gst_csd_track_dec_start(GstAggregator *aggregator) {
  auto *self = GST_CSD_TRACK_DEC(aggregator);
  std::unique_ptr<csd::TrackFile> file;
  return open_file(self, file) && guard.posted(self, [&] { start_anew(self, std::move(file)); });
}

gboolean gst_csd_track_dec_stop(GstAggregator *aggregator) {
  auto *self = GST_CSD_TRACK_DEC(aggregator);
  guard.logged(self, [&] { start_anew(self, nullptr); });
  return TRUE;
}

void set_running(GstCsdTrackDec *self, bool running) {
  const csd::ObjectLock lock(self);
  self->state->running = running;
}

GstStateChangeReturn gst_csd_track_dec_change_state(GstElement *element, GstStateChange transition) {
  auto *self = GST_CSD_TRACK_DEC(element);
  std::unique_ptr<csd::TrackFile> unused;  // opened now only to report errors
  if (transition == GST_STATE_CHANGE_NULL_TO_READY && !open_file(self, unused)) return GST_STATE_CHANGE_FAILURE;
  const bool starts = transition == GST_STATE_CHANGE_READY_TO_PAUSED;
  if (starts) set_running(self, true);
  const auto result = GST_ELEMENT_CLASS(gst_csd_track_dec_parent_class)->change_state(element, transition);
  if (transition == GST_STATE_CHANGE_PAUSED_TO_READY || (starts && result == GST_STATE_CHANGE_FAILURE))
    set_running(self, false);
  return result;
}

// ---- Properties ----------------------------------------------------------------------------------------------------

void overlay_changed(gpointer object) {
  auto &state = *GST_CSD_TRACK_DEC(object)->state;
  state.overlay.see_value(state.values.live.overlay);
}

/// Made, and installed, by the first call, in class_init.
const csd::PropertyTable<csd::DecValues> &properties_of(gpointer klass) {
  static const csd::PropertyTable<csd::DecValues> table(G_OBJECT_CLASS(klass), csd::dec_properties(overlay_changed),
                                                        gst_csd_track_dec_debug);
  return table;
}

void gst_csd_track_dec_set_property(GObject *object, guint id, const GValue *value, GParamSpec *) {
  auto &state = *GST_CSD_TRACK_DEC(object)->state;
  guard.logged(object,
               [&] { properties_of(G_OBJECT_GET_CLASS(object)).set(object, state.values, state.running, id, value); });
}

void gst_csd_track_dec_get_property(GObject *object, guint id, GValue *value, GParamSpec *) {
  guard.logged(object, [&] {
    properties_of(G_OBJECT_GET_CLASS(object)).get(object, GST_CSD_TRACK_DEC(object)->state->values, id, value);
  });
}

void gst_csd_track_dec_finalize(GObject *object) {
  delete GST_CSD_TRACK_DEC(object)->state;
  G_OBJECT_CLASS(gst_csd_track_dec_parent_class)->finalize(object);
}

}  // namespace

static void gst_csd_track_dec_class_init(GstCsdTrackDecClass *klass) {
  auto *object_class = G_OBJECT_CLASS(klass);
  auto *element_class = GST_ELEMENT_CLASS(klass);
  auto *aggregator_class = GST_AGGREGATOR_CLASS(klass);
  object_class->set_property = gst_csd_track_dec_set_property;
  object_class->get_property = gst_csd_track_dec_get_property;
  object_class->finalize = gst_csd_track_dec_finalize;
  properties_of(klass);

  gst_element_class_set_static_metadata(element_class, "Track decoder", "Filter/Metadata/Video",
                                        "Puts recorded tracks back on video frames, and shows them if wanted",
                                        "The csdtrack authors");
  csd::add_dec_pad_templates(element_class);
  element_class->change_state = GST_DEBUG_FUNCPTR(gst_csd_track_dec_change_state);
  element_class->release_pad = GST_DEBUG_FUNCPTR(gst_csd_track_dec_release_pad);
  aggregator_class->create_new_pad = GST_DEBUG_FUNCPTR(gst_csd_track_dec_create_new_pad);
  aggregator_class->clip = GST_DEBUG_FUNCPTR(gst_csd_track_dec_clip);
  aggregator_class->get_next_time = GST_DEBUG_FUNCPTR(gst_csd_track_dec_get_next_time);
  aggregator_class->aggregate = GST_DEBUG_FUNCPTR(gst_csd_track_dec_aggregate);
  aggregator_class->negotiate = GST_DEBUG_FUNCPTR(gst_csd_track_dec_negotiate);
  aggregator_class->sink_event_pre_queue = GST_DEBUG_FUNCPTR(gst_csd_track_dec_sink_event_pre_queue);
  aggregator_class->sink_event = GST_DEBUG_FUNCPTR(gst_csd_track_dec_sink_event);
  aggregator_class->src_event = GST_DEBUG_FUNCPTR(gst_csd_track_dec_src_event);
  aggregator_class->sink_query = GST_DEBUG_FUNCPTR(gst_csd_track_dec_sink_query);
  aggregator_class->src_query = GST_DEBUG_FUNCPTR(gst_csd_track_dec_src_query);
  aggregator_class->start = GST_DEBUG_FUNCPTR(gst_csd_track_dec_start);
  aggregator_class->stop = GST_DEBUG_FUNCPTR(gst_csd_track_dec_stop);
}

static void gst_csd_track_dec_init(GstCsdTrackDec *self) {
  GstPadTemplate *templ = gst_element_class_get_pad_template(GST_ELEMENT_GET_CLASS(self), "sink");
  auto *sink = GST_PAD(
      g_object_new(GST_TYPE_AGGREGATOR_PAD, "name", "sink", "direction", GST_PAD_SINK, "template", templ, nullptr));
  gst_element_add_pad(GST_ELEMENT(self), sink);
  self->state = new GstCsdTrackDecState(GST_ELEMENT(self), sink);
  gst_pad_set_chain_function(sink, GST_DEBUG_FUNCPTR(gst_csd_track_dec_chain));
}
