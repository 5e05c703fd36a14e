// SPDX-License-Identifier: LGPL-2.1-or-later

/**
 * SECTION:element-csdtrackenc
 * @title: csdtrackenc
 * @short_description: writes the tracks on frames as text
 *
 * Writes the tracks that csdtrack attached to frames as text. It maps no pixels and takes raw video of any format in
 * any memory, so it works behind a `tee` or inline.
 *
 * The output format is negotiated with downstream:
 *
 * * `application/x-ndjson` (the first choice): a line of JSON per frame
 * * `text/csv`: a row per feature per frame, under a header. The header is a buffer of its own, flagged HEADER, and
 *   `streamheader` in the caps. It is sent again after a flush, where filesink restarts its file
 * * `text/x-raw,format=utf8`: the line of JSON without its newline, for a subtitle track
 * * `meta/x-klv`: the same in a packet of SMPTE 336, for MPEG-TS and RTP
 *
 * With `role=truth` it writes the ground truth that csdsimsrc attached, in the same forms, for csd-score.
 *
 * There is one buffer per frame, with the frame's timestamp and duration. MP4 can't hold a text longer than 65535
 * bytes, nor an MPEG-TS packet one longer than 65000: a longer line becomes several buffers that divide the frame's
 * time among them. A frame without tracks gives an empty list in JSON, and a GAP event in CSV (if it has a timestamp).
 * docs/metadata.md describes all fields.
 *
 * When it is linked to another peer while it runs, it negotiates again before the next frame.
 *
 * filesink buffers 64 KiB by default, which a crash loses. With `buffer-mode=unbuffered` the file holds everything
 * written so far, except that the last line may be torn; readers ignore such a line.
 *
 * ## Example launch lines
 * |[
 * gst-launch-1.0 filesrc location=in.mp4 ! decodebin ! csdtrack ! csdtrackenc \
 *   ! filesink location=tracks.jsonl buffer-mode=unbuffered
 * ]| Tracks only.
 * |[
 * gst-launch-1.0 filesrc location=in.mp4 ! decodebin ! csdtrack ! tee name=t \
 *   t. ! queue ! x264enc ! h264parse ! mp4mux ! filesink location=out.mp4 \
 *   t. ! csdtrackenc ! text/csv ! queue max-size-time=5000000000 max-size-buffers=0 max-size-bytes=0 \
 *   ! filesink location=tracks.csv buffer-mode=unbuffered
 * ]| A recording and a table beside it. The second queue must outlast what the encoder holds back while the
 * pipeline starts.
 * |[
 * gst-launch-1.0 -q filesrc location=in.mp4 ! decodebin ! csdtrack ! csdtrackenc ! fdsink | jq '.features | length'
 * ]| Into another program. (To write a file use filesink: fdsink writes from the file's beginning.)
 * |[
 * gst-launch-1.0 v4l2src ! csdtrack ! csdtrackenc ! tcpserversink host=127.0.0.1 port=4953
 * ]| Over the network.
 * |[
 * gst-launch-1.0 filesrc location=in.mp4 ! decodebin ! csdtrack ! tee name=t \
 *   matroskamux name=m ! filesink location=out.mkv \
 *   t. ! queue ! x264enc ! h264parse ! m. \
 *   t. ! csdtrackenc ! queue max-size-time=5000000000 max-size-buffers=0 max-size-bytes=0 ! m.subtitle_0
 * ]| The tracks as a subtitle track of the recording. The queue behind csdtrackenc must hold more time than the encoder
 * holds back, or the muxer waits forever. With `mpegtsmux`, `out.ts` and `m.` for `m.subtitle_0` they are KLV.
 *
 * Since: 0.1
 */

#include "elements/csdtrackenc.h"

#include <gst/video/video.h>

#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "meta/meta.h"
#include "record/klv.h"
#include "record/text_pieces.h"
#include "record/track_format.h"
#include "support/enc_properties.h"
#include "support/enums.h"
#include "support/guard.h"
#include "support/lock.h"

GST_DEBUG_CATEGORY_STATIC(gst_csd_track_enc_debug);
#define GST_CAT_DEFAULT gst_csd_track_enc_debug

namespace {

enum class Format { ndjson, csv, text, klv };

struct Offer {
  Format format;
  const char *caps;
};
/// In order of preference.
constexpr Offer offers[] = {{Format::ndjson, "application/x-ndjson"},
                            {Format::csv, "text/csv"},
                            {Format::text, "text/x-raw, format=(string)utf8"},
                            {Format::klv, "meta/x-klv, parsed=(boolean)true"}};

using CapsPtr = std::unique_ptr<GstCaps, decltype(&gst_caps_unref)>;
using StringPtr = std::unique_ptr<char, decltype(&g_free)>;

/// State of the stream. Only the sink pad's streaming thread uses it, and the state change to READY once the pads are
/// inactive.
struct Stream {
  GstSegment segment;
  const Offer *offer = nullptr;                       ///< null until negotiated
  bool header_due = false;                            ///< CSV only
  bool discont_due = false;                           ///< of a frame that became a GAP event
  bool tags_due = true;                               ///< title and language, until the video brings tags
  int width = 0, height = 0;                          ///< from the caps; 0: unknown
  int pixel_aspect_n = 1, pixel_aspect_d = 1;         ///< from the caps
  GstClockTime frame_duration = GST_CLOCK_TIME_NONE;  ///< from the framerate
  std::string line;                                   ///< reused to avoid allocations
  std::uint64_t count = 0;                            ///< frames so far, for KLV

  Stream() { gst_segment_init(&segment, GST_FORMAT_UNDEFINED); }
};

}  // namespace

struct GstCsdTrackEncState {
  csd::EncValues settings;  ///< guarded by the object lock
  Stream stream;
};

struct _GstCsdTrackEnc {
  GstElement parent;
  GstPad *sinkpad;
  GstPad *srcpad;
  GstCsdTrackEncState *state;
};

G_DEFINE_TYPE_WITH_CODE(GstCsdTrackEnc, gst_csd_track_enc, GST_TYPE_ELEMENT,
                        GST_DEBUG_CATEGORY_INIT(gst_csd_track_enc_debug, "csdtrackenc", 0, "tracks as text"))
GST_ELEMENT_REGISTER_DEFINE_WITH_CODE(csdtrackenc, "csdtrackenc", GST_RANK_NONE, GST_TYPE_CSD_TRACK_ENC,
                                      csd::register_track_metas())

namespace {

GstStaticPadTemplate sink_template =
    GST_STATIC_PAD_TEMPLATE("sink", GST_PAD_SINK, GST_PAD_ALWAYS, GST_STATIC_CAPS("video/x-raw(ANY)"));
GstStaticPadTemplate src_template =
    GST_STATIC_PAD_TEMPLATE("src", GST_PAD_SRC, GST_PAD_ALWAYS,
                            GST_STATIC_CAPS("application/x-ndjson; text/csv; text/x-raw, format=(string)utf8; "
                                            "meta/x-klv, parsed=(boolean)true"));

const csd::Guard guard(gst_csd_track_enc_debug, "A frame's tracks could not be written: free some memory.",
                       "A frame's tracks could not be written", "");

Stream &stream_of(GstCsdTrackEnc *self) {
  return self->state->stream;
}

csd::EncValues settings_of(GstCsdTrackEnc *self) {
  const csd::ObjectLock lock(self);
  return self->state->settings;
}

// --- negotiation -----------------------------------------------------------------------------------------------------

GstBuffer *new_text_buffer(std::string_view text) {
  GstBuffer *buffer = gst_buffer_new_allocate(nullptr, text.size(), nullptr);
  if (!buffer) throw std::bad_alloc();
  gst_buffer_fill(buffer, 0, text.data(), text.size());
  return buffer;
}

GstBuffer *new_csv_header() {
  GstBuffer *buffer = new_text_buffer(csd::csv_header);
  GST_BUFFER_FLAG_SET(buffer, GST_BUFFER_FLAG_HEADER);
  return buffer;
}

/// Our first format that downstream accepts. Without downstream, all are accepted.
const Offer *choose(GstCsdTrackEnc *self) {
  const CapsPtr allowed(gst_pad_peer_query_caps(self->srcpad, nullptr), gst_caps_unref);
  for (const Offer &offer : offers) {
    const CapsPtr caps(gst_caps_from_string(offer.caps), gst_caps_unref);
    if (gst_caps_can_intersect(caps.get(), allowed.get())) return &offer;
  }
  return nullptr;
}

/// Sends the offer's caps, if they are others than before. Returns false if downstream refuses them.
bool send_caps(GstCsdTrackEnc *self, const Offer *offer) {
  Stream &stream = stream_of(self);
  if (stream.offer == offer) return true;
  GST_INFO_OBJECT(self, "writing %s", offer->caps);
  GstCaps *caps = gst_caps_from_string(offer->caps);
  if (offer->format == Format::csv) {
    GValue headers = G_VALUE_INIT;
    GValue header = G_VALUE_INIT;
    g_value_init(&headers, GST_TYPE_ARRAY);
    g_value_init(&header, GST_TYPE_BUFFER);
    gst_value_take_buffer(&header, new_csv_header());
    gst_value_array_append_and_take_value(&headers, &header);
    gst_structure_take_value(gst_caps_get_structure(caps, 0), "streamheader", &headers);
  }
  const bool taken = gst_pad_push_event(self->srcpad, gst_event_new_caps(caps));
  gst_caps_unref(caps);
  // An unlinked pad keeps the event. The first push reports that it isn't linked.
  if (!taken && gst_pad_is_linked(self->srcpad)) {
    stream.offer = nullptr;
    return false;
  }
  stream.offer = offer;
  stream.header_due = offer->format == Format::csv;
  return true;
}

/// Negotiates with downstream. Posts an error if there is no common format.
bool negotiate(GstCsdTrackEnc *self) {
  gst_pad_check_reconfigure(self->srcpad);  // clears the mark
  const Offer *offer = choose(self);
  if (offer && send_caps(self, offer)) return true;
  gst_pad_mark_reconfigure(self->srcpad);
  if (offer) return false;
  stream_of(self).offer = nullptr;
  GST_ELEMENT_ERROR(self, CORE, NEGOTIATION,
                    ("Downstream takes none of the forms that tracks come in. Link csdtrackenc to an element that "
                     "takes application/x-ndjson, text/csv, text/x-raw,format=utf8 or meta/x-klv,parsed=true."),
                    (nullptr));
  return false;
}

/// Pushing an event also pushes the sticky ones that a new peer lacks, among them our caps, which it may not take. So
/// they are chosen anew before. A failure is left to the next frame, because the peer may not be linked on yet.
void negotiate_before(GstCsdTrackEnc *self, GstEvent *event) {
  switch (GST_EVENT_TYPE(event)) {
    case GST_EVENT_STREAM_START:  // goes before the caps
    case GST_EVENT_CAPS:          // negotiates itself
    case GST_EVENT_FLUSH_STOP:
      return;
    default:
      break;
  }
  const bool serialized = (gst_event_type_get_flags(GST_EVENT_TYPE(event)) & GST_EVENT_TYPE_SERIALIZED) != 0;
  if (!serialized || !stream_of(self).offer || !gst_pad_check_reconfigure(self->srcpad)) return;
  const Offer *offer = choose(self);
  if (!offer || !send_caps(self, offer)) gst_pad_mark_reconfigure(self->srcpad);
}

bool set_caps(GstCsdTrackEnc *self, const GstCaps *caps) {
  Stream &stream = stream_of(self);
  // Read as fields: GstVideoInfo doesn't know every memory's formats, and nothing else is needed.
  const GstStructure *s = gst_caps_get_structure(caps, 0);
  if (!gst_structure_get_int(s, "width", &stream.width)) stream.width = 0;
  if (!gst_structure_get_int(s, "height", &stream.height)) stream.height = 0;
  if (!gst_structure_get_fraction(s, "pixel-aspect-ratio", &stream.pixel_aspect_n, &stream.pixel_aspect_d))
    stream.pixel_aspect_n = stream.pixel_aspect_d = 1;
  int n = 0, d = 0;
  const bool known = gst_structure_get_fraction(s, "framerate", &n, &d) && n > 0 && d > 0;
  stream.frame_duration = known ? gst_util_uint64_scale_int(GST_SECOND, d, n) : GST_CLOCK_TIME_NONE;
  return negotiate(self);
}

// --- frames ----------------------------------------------------------------------------------------------------------

/// Tracks refer to the crop rectangle at the time of tracking. videocrop may add another one without touching pixels or
/// tracks, if downstream allows: then they refer to the whole frame, or to an unknown one.
void lay_crop(csd::FrameRecord &record, GstBuffer *frame) {
  const GstVideoCropMeta *crop = gst_buffer_get_video_crop_meta(frame);
  GstCsdHeader header;
  if (!crop || !record.tracks || !gst_csd_structure_get_header(record.tracks, &header)) return;
  const auto width = static_cast<guint>(header.width), height = static_cast<guint>(header.height);
  if (width == crop->width && height == crop->height) return;
  const GstVideoMeta *whole = gst_buffer_get_video_meta(frame);
  if (whole && width == whole->width && height == whole->height)
    record.crop = crop;
  else
    record.tracks = nullptr;
}

/// Writes the frame as text to stream.line.
void write_frame(GstCsdTrackEnc *self, GstBuffer *frame, Stream &stream) {
  const csd::EncValues settings = settings_of(self);
  const bool truth = settings.role == GST_CSD_TRACK_ENC_ROLE_TRUTH;
  csd::FrameRecord record;
  record.tracks = gst_buffer_get_csd_tracks(frame, truth ? GST_CSD_TRUTH_META_NAME : GST_CSD_TRACK_META_NAME,
                                            settings.source.c_str());
  if (truth) record.role = "truth";
  lay_crop(record, frame);
  record.width = stream.width;
  record.height = stream.height;
  record.pixel_aspect_n = stream.pixel_aspect_n;
  record.pixel_aspect_d = stream.pixel_aspect_d;
  record.pts = GST_BUFFER_PTS(frame);
  record.duration = GST_BUFFER_DURATION(frame);
  if (stream.segment.format == GST_FORMAT_TIME && GST_CLOCK_TIME_IS_VALID(record.pts)) {
    record.running_time = gst_segment_to_running_time(&stream.segment, GST_FORMAT_TIME, record.pts);
    record.stream_time = gst_segment_to_stream_time(&stream.segment, GST_FORMAT_TIME, record.pts);
  }
  StringPtr reference(nullptr, g_free);
  if (const GstReferenceTimestampMeta *meta = gst_buffer_get_reference_timestamp_meta(frame, nullptr)) {
    reference.reset(gst_caps_to_string(meta->reference));
    record.reference_caps = reference.get();
    record.reference_time = meta->timestamp;
  }

  stream.line.clear();
  switch (stream.offer->format) {
    case Format::ndjson:
      csd::append_json(stream.line, record);
      stream.line += '\n';
      break;
    case Format::csv:
      csd::append_csv(stream.line, record);
      break;
    case Format::text:
    case Format::klv:
      csd::append_json(stream.line, record);
      break;
  }
}

/// A new buffer with `text` and the frame's time.
GstBuffer *new_frame_text(GstBuffer *frame, std::string_view text) {
  GstBuffer *buffer = new_text_buffer(text);
  GST_BUFFER_PTS(buffer) = GST_BUFFER_PTS(frame);
  GST_BUFFER_DURATION(buffer) = GST_BUFFER_DURATION(frame);
  if (GST_BUFFER_FLAG_IS_SET(frame, GST_BUFFER_FLAG_DISCONT)) GST_BUFFER_FLAG_SET(buffer, GST_BUFFER_FLAG_DISCONT);
  return buffer;
}

/// Pushes subtitles or KLV. Pieces of a line divide the frame's time among them: mp4mux loses the last ones of several
/// samples with one timestamp, and in RTP all packets of one timestamp are one KLV unit.
GstFlowReturn push_track(GstCsdTrackEnc *self, GstBuffer *frame, Stream &stream) {
  const bool klv = stream.offer->format == Format::klv;
  // A subtitle without a duration stays up until the next one, or forever.
  const GstClockTime duration =
      GST_BUFFER_DURATION_IS_VALID(frame) ? GST_BUFFER_DURATION(frame) : stream.frame_duration;
  const std::vector<std::string_view> pieces =
      csd::text_pieces(stream.line, klv ? csd::max_klv_text : csd::max_piece_bytes);
  ++stream.count;
  GstFlowReturn flow = GST_FLOW_OK;
  for (std::size_t i = 0; i < pieces.size() && flow == GST_FLOW_OK; ++i) {
    GstBuffer *text = klv ? new_frame_text(frame, csd::klv_packet(pieces[i], stream.count, i, pieces.size()))
                          : new_frame_text(frame, pieces[i]);
    if (i > 0) GST_BUFFER_FLAG_UNSET(text, GST_BUFFER_FLAG_DISCONT);
    if (GST_CLOCK_TIME_IS_VALID(duration)) {
      const GstClockTime begin = gst_util_uint64_scale(duration, i, pieces.size());
      if (GST_BUFFER_PTS_IS_VALID(frame)) GST_BUFFER_PTS(text) += begin;
      GST_BUFFER_DURATION(text) = gst_util_uint64_scale(duration, i + 1, pieces.size()) - begin;
    }
    flow = gst_pad_push(self->srcpad, text);
  }
  return flow;
}

/// Sends the CSV header once, before the first frame, or at the end of a stream without frames.
GstFlowReturn push_due_header(GstCsdTrackEnc *self) {
  Stream &stream = stream_of(self);
  if (!stream.header_due) return GST_FLOW_OK;
  const GstFlowReturn flow = gst_pad_push(self->srcpad, new_csv_header());
  stream.header_due = flow != GST_FLOW_OK;
  return flow;
}

/// Sets the title a player shows for the text track, and no language, so that its menu doesn't offer it as a subtitle.
void name_track(GstTagList *tags) {
  gst_tag_list_add(tags, GST_TAG_MERGE_REPLACE, GST_TAG_TITLE, "csdtrack", GST_TAG_LANGUAGE_CODE, "zxx", nullptr);
}

void push_due_tags(GstCsdTrackEnc *self) {
  if (!std::exchange(stream_of(self).tags_due, false)) return;
  GstTagList *tags = gst_tag_list_new_empty();
  gst_tag_list_set_scope(tags, GST_TAG_SCOPE_STREAM);
  name_track(tags);
  gst_pad_push_event(self->srcpad, gst_event_new_tag(tags));
}

/// CSV has nothing to say about a frame without features but that its time has passed: a buffer without bytes would
/// make tcpserversink abort. A GAP event needs a time.
GstFlowReturn push_gap(GstCsdTrackEnc *self, GstBuffer *frame) {
  if (GST_BUFFER_FLAG_IS_SET(frame, GST_BUFFER_FLAG_DISCONT)) stream_of(self).discont_due = true;
  if (!GST_BUFFER_PTS_IS_VALID(frame)) return GST_FLOW_OK;
  GstEvent *gap = gst_event_new_gap(GST_BUFFER_PTS(frame), GST_BUFFER_DURATION(frame));
  if (gst_pad_push_event(self->srcpad, gap)) return GST_FLOW_OK;
  if (GST_PAD_IS_FLUSHING(self->srcpad)) return GST_FLOW_FLUSHING;
  if (GST_PAD_IS_EOS(self->srcpad)) return GST_FLOW_EOS;
  return GST_FLOW_OK;  // what is wrong downstream, the next buffer tells
}

GstFlowReturn push_rows(GstCsdTrackEnc *self, GstBuffer *frame, Stream &stream) {
  if (stream.line.empty()) return push_gap(self, frame);
  GstBuffer *rows = new_frame_text(frame, stream.line);
  if (std::exchange(stream.discont_due, false)) GST_BUFFER_FLAG_SET(rows, GST_BUFFER_FLAG_DISCONT);
  return gst_pad_push(self->srcpad, rows);
}

GstFlowReturn push_text(GstCsdTrackEnc *self, GstBuffer *frame) {
  Stream &stream = stream_of(self);
  if (gst_pad_check_reconfigure(self->srcpad) && !negotiate(self)) {
    return GST_PAD_IS_FLUSHING(self->srcpad) ? GST_FLOW_FLUSHING : GST_FLOW_NOT_NEGOTIATED;
  }
  if (!stream.offer) return GST_FLOW_NOT_NEGOTIATED;
  push_due_tags(self);
  const GstFlowReturn flow = push_due_header(self);
  if (flow != GST_FLOW_OK) return flow;
  write_frame(self, frame, stream);
  switch (stream.offer->format) {
    case Format::ndjson:
      return gst_pad_push(self->srcpad, new_frame_text(frame, stream.line));
    case Format::csv:
      return push_rows(self, frame, stream);
    default:
      return push_track(self, frame, stream);
  }
}

GstFlowReturn gst_csd_track_enc_chain(GstPad *, GstObject *parent, GstBuffer *frame) {
  auto *self = GST_CSD_TRACK_ENC(parent);
  GstFlowReturn flow = GST_FLOW_ERROR;
  guard.posted(self, [&] { flow = push_text(self, frame); });
  gst_buffer_unref(frame);
  return flow;
}

// --- events and queries ----------------------------------------------------------------------------------------------

/// A stream id different from the video's, with the same group and flags.
GstEvent *text_stream_start(GstEvent *video) {
  const gchar *video_id = nullptr;
  GstStreamFlags flags = GST_STREAM_FLAG_NONE;
  guint group = 0;
  gst_event_parse_stream_start(video, &video_id);
  gst_event_parse_stream_flags(video, &flags);
  const StringPtr id(g_strconcat(video_id, "/csdtracks", nullptr), g_free);
  GstEvent *text = gst_event_new_stream_start(id.get());
  gst_event_set_seqnum(text, gst_event_get_seqnum(video));
  gst_event_set_stream_flags(text, flags);
  if (gst_event_parse_group_id(video, &group)) gst_event_set_group_id(text, group);
  gst_event_unref(video);
  return text;
}

/// Drops the video's codec, title and language tags, which don't apply to the text.
GstEvent *text_tags(GstEvent *video, Stream &stream) {
  static const char *const of_video[] = {
      GST_TAG_CODEC,           GST_TAG_VIDEO_CODEC,      GST_TAG_AUDIO_CODEC,     GST_TAG_BITRATE,
      GST_TAG_NOMINAL_BITRATE, GST_TAG_MINIMUM_BITRATE,  GST_TAG_MAXIMUM_BITRATE, GST_TAG_ENCODER,
      GST_TAG_ENCODER_VERSION, GST_TAG_CONTAINER_FORMAT, GST_TAG_LANGUAGE_NAME,   GST_TAG_TITLE_SORTNAME};
  GstTagList *tags = nullptr;
  gst_event_parse_tag(video, &tags);
  if (gst_tag_list_get_scope(tags) == GST_TAG_SCOPE_GLOBAL) return video;
  tags = gst_tag_list_copy(tags);
  for (const char *tag : of_video) gst_tag_list_remove_tag(tags, tag);
  name_track(tags);
  stream.tags_due = false;
  GstEvent *text = gst_event_new_tag(tags);
  gst_event_set_seqnum(text, gst_event_get_seqnum(video));
  gst_event_unref(video);
  return text;
}

gboolean gst_csd_track_enc_sink_event(GstPad *pad, GstObject *parent, GstEvent *event) {
  auto *self = GST_CSD_TRACK_ENC(parent);
  Stream &stream = stream_of(self);
  guard.posted(self, [&] { negotiate_before(self, event); });
  switch (GST_EVENT_TYPE(event)) {
    case GST_EVENT_CAPS: {
      GstCaps *caps = nullptr;
      gst_event_parse_caps(event, &caps);
      bool agreed = false;
      guard.posted(self, [&] { agreed = set_caps(self, caps); });
      gst_event_unref(event);
      return agreed;
    }
    case GST_EVENT_SEGMENT:
      gst_event_copy_segment(event, &stream.segment);
      break;
    case GST_EVENT_FLUSH_STOP:
      gst_segment_init(&stream.segment, GST_FORMAT_UNDEFINED);
      stream.header_due = stream.offer && stream.offer->format == Format::csv;
      stream.discont_due = false;
      break;
    case GST_EVENT_EOS:
      guard.posted(self, [&] { push_due_header(self); });
      break;
    case GST_EVENT_STREAM_START:
      event = text_stream_start(event);
      stream.tags_due = true;
      break;
    case GST_EVENT_TAG:
      event = text_tags(event, stream);
      break;
    default:
      break;
  }
  return gst_pad_event_default(pad, parent, event);
}

/// A late text branch must not make a decoder skip frames, which a recording beside it would lose.
gboolean gst_csd_track_enc_src_event(GstPad *pad, GstObject *parent, GstEvent *event) {
  if (GST_EVENT_TYPE(event) != GST_EVENT_QOS) return gst_pad_event_default(pad, parent, event);
  gst_event_unref(event);
  return TRUE;
}

/// This element maps no pixels, so it accepts any layout, crop or overlay metas. Without this answer a tee would report
/// them as unsupported, and upstream would copy or blend for all branches.
gboolean gst_csd_track_enc_sink_query(GstPad *pad, GstObject *parent, GstQuery *query) {
  if (GST_QUERY_TYPE(query) != GST_QUERY_ALLOCATION) return gst_pad_query_default(pad, parent, query);
  for (const GType api :
       {GST_VIDEO_META_API_TYPE, GST_VIDEO_CROP_META_API_TYPE, GST_VIDEO_OVERLAY_COMPOSITION_META_API_TYPE})
    gst_query_add_allocation_meta(query, api, nullptr);
  return TRUE;
}

GstStateChangeReturn gst_csd_track_enc_change_state(GstElement *element, GstStateChange transition) {
  auto *self = GST_CSD_TRACK_ENC(element);
  const auto result = GST_ELEMENT_CLASS(gst_csd_track_enc_parent_class)->change_state(element, transition);
  if (transition == GST_STATE_CHANGE_PAUSED_TO_READY) stream_of(self) = Stream();
  return result;
}

// --- the object ------------------------------------------------------------------------------------------------------

const csd::PropertyTable<csd::EncValues> &properties_of(gpointer klass) {
  static const csd::PropertyTable<csd::EncValues> table(G_OBJECT_CLASS(klass), csd::enc_properties(), GST_CAT_DEFAULT);
  return table;
}

void gst_csd_track_enc_set_property(GObject *object, guint id, const GValue *value, GParamSpec *) {
  auto *self = GST_CSD_TRACK_ENC(object);
  // None is for READY only.
  guard.logged(self,
               [&] { properties_of(G_OBJECT_GET_CLASS(object)).set(self, self->state->settings, false, id, value); });
}

void gst_csd_track_enc_get_property(GObject *object, guint id, GValue *value, GParamSpec *) {
  auto *self = GST_CSD_TRACK_ENC(object);
  properties_of(G_OBJECT_GET_CLASS(object)).get(self, self->state->settings, id, value);
}

void gst_csd_track_enc_finalize(GObject *object) {
  delete GST_CSD_TRACK_ENC(object)->state;
  G_OBJECT_CLASS(gst_csd_track_enc_parent_class)->finalize(object);
}

}  // namespace

static void gst_csd_track_enc_class_init(GstCsdTrackEncClass *klass) {
  auto *object_class = G_OBJECT_CLASS(klass);
  auto *element_class = GST_ELEMENT_CLASS(klass);
  object_class->set_property = gst_csd_track_enc_set_property;
  object_class->get_property = gst_csd_track_enc_get_property;
  object_class->finalize = gst_csd_track_enc_finalize;
  element_class->change_state = GST_DEBUG_FUNCPTR(gst_csd_track_enc_change_state);

  properties_of(object_class);

  gst_element_class_add_static_pad_template(element_class, &sink_template);
  gst_element_class_add_static_pad_template(element_class, &src_template);
  gst_element_class_set_static_metadata(element_class, "Track encoder", "Codec/Encoder/Metadata",
                                        "Writes the tracks on video frames as JSON lines, CSV, a text track or KLV",
                                        "The csdtrack authors");
}

static void gst_csd_track_enc_init(GstCsdTrackEnc *self) {
  self->state = new GstCsdTrackEncState();

  self->sinkpad = gst_pad_new_from_static_template(&sink_template, "sink");
  gst_pad_set_chain_function(self->sinkpad, GST_DEBUG_FUNCPTR(gst_csd_track_enc_chain));
  gst_pad_set_event_function(self->sinkpad, GST_DEBUG_FUNCPTR(gst_csd_track_enc_sink_event));
  gst_pad_set_query_function(self->sinkpad, GST_DEBUG_FUNCPTR(gst_csd_track_enc_sink_query));
  gst_element_add_pad(GST_ELEMENT_CAST(self), self->sinkpad);

  self->srcpad = gst_pad_new_from_static_template(&src_template, "src");
  // No fixed caps: a CAPS query is answered with all that the element can write, so that a peer of another form can be
  // linked in mid-stream.
  gst_pad_set_event_function(self->srcpad, GST_DEBUG_FUNCPTR(gst_csd_track_enc_src_event));
  gst_element_add_pad(GST_ELEMENT_CAST(self), self->srcpad);
}
