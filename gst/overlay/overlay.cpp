// SPDX-License-Identifier: LGPL-2.1-or-later
#include "overlay/overlay.h"

#include <stdexcept>
#include <utility>

#include "caps/frame_mapping.h"
#include "overlay/row_painter.h"
#include "support/guard.h"
#include "support/lock.h"

namespace csd {

static constexpr char no_drawing[] =
    "overlay=draw can't draw into these frames, for they are not in system memory, or of a format that can't be drawn "
    "into. Use overlay=meta or none, or download and convert the frames before.";

GParamSpec *Overlay::param_spec() {
  return g_param_spec_enum(
      "overlay", "Overlay",
      "How features are shown. draw: in the pixels. meta: as a GstVideoOverlayComposition beside them; "
      "if downstream can't show it, one WARNING says so, and the pixels stay as they are",
      GST_TYPE_CSD_TRACK_OVERLAY, GST_CSD_TRACK_OVERLAY_NONE,
      static_cast<GParamFlags>(G_PARAM_READWRITE | G_PARAM_STATIC_STRINGS | GST_PARAM_MUTABLE_PLAYING |
                               GST_PARAM_CONTROLLABLE));
}

void Overlay::see_value(const GstCsdTrackOverlay &overlay) {
  const std::lock_guard lock(values_);
  GstCsdTrackOverlay value;
  {
    const ObjectLock object_lock(element_);
    value = overlay;
  }
  // Later, with a caps query, there is nobody to tell a failure to.
  if (value == GST_CSD_TRACK_OVERLAY_DRAW) gst_caps_unref(drawable_caps());
  draws_ = value == GST_CSD_TRACK_OVERLAY_DRAW;
  negotiation_.set_wanted(value == GST_CSD_TRACK_OVERLAY_META);
}

GstCaps *Overlay::transform_caps(GstPadDirection direction, GstCaps *caps, GstCaps *filter) const noexcept {
  GstCaps *other = nullptr;
  if (const auto failure = guarded([&] { other = negotiation_.transform_caps(direction, caps); })) {
    GST_ERROR_OBJECT(element_, "%s", failure->detail.c_str());
    other = gst_caps_ref(caps);
  }
  const auto narrow = [&other](GstCaps *first, GstCaps *second) {
    GstCaps *both = gst_caps_intersect_full(first, second, GST_CAPS_INTERSECT_FIRST);
    gst_caps_unref(other);
    other = both;
  };
  // Offers upstream only what can be drawn into. Other caps aren't refused here: can_show() reports why.
  if (draws_ && direction == GST_PAD_SRC) {
    GstCaps *drawable = drawable_caps();
    narrow(other, drawable);
    gst_caps_unref(drawable);
  }
  if (filter) narrow(filter, other);
  return other;
}

void Overlay::answer_caps(GstPadDirection direction, GstQuery *query) const {
  const bool at_sink = direction == GST_PAD_SINK;
  if (GST_QUERY_TYPE(query) == GST_QUERY_ACCEPT_CAPS) {
    GstCaps *caps = nullptr;
    gst_query_parse_accept_caps(query, &caps);
    // Upstream's caps aren't refused here, which says nothing to the user: can_show() and the negotiation say why.
    GstCaps *complete = complete_caps(caps),
            *possible = at_sink ? gst_pad_get_pad_template_caps(sink_) : gst_pad_query_caps(src_, complete);
    gst_query_set_accept_caps_result(query, gst_caps_is_subset(complete, possible));
    gst_caps_unref(complete);
    gst_caps_unref(possible);
    return;
  }
  GstCaps *filter = nullptr;
  gst_query_parse_caps(query, &filter);
  GstCaps *their_filter = filter ? transform_caps(direction, filter, nullptr) : nullptr;
  GstCaps *theirs = gst_pad_peer_query_caps(at_sink ? src_ : sink_, their_filter);
  GstCaps *whole = gst_pad_get_pad_template_caps(at_sink ? sink_ : src_);
  GstCaps *known = gst_caps_intersect_full(theirs, whole, GST_CAPS_INTERSECT_FIRST);
  GstCaps *ours = transform_caps(at_sink ? GST_PAD_SRC : GST_PAD_SINK, known, filter);
  gst_query_set_caps_result(query, ours);
  gst_clear_caps(&their_filter);
  for (GstCaps *each : {theirs, whole, known, ours}) gst_caps_unref(each);
}

GstCaps *Overlay::choose_caps(GstCaps *in) const {
  GstCaps *possible = transform_caps(GST_PAD_SINK, in, nullptr);
  GstCaps *theirs = gst_pad_peer_query_caps(src_, possible);
  GstCaps *both = prefer(GST_PAD_SINK, gst_caps_intersect_full(possible, theirs, GST_CAPS_INTERSECT_FIRST));
  gst_caps_unref(possible);
  gst_caps_unref(theirs);
  return gst_caps_is_empty(both) ? both : gst_caps_fixate(both);
}

void Overlay::see_event(GstEvent *event) {
  if (GST_EVENT_TYPE(event) == GST_EVENT_RECONFIGURE) negotiation_.restart();
}

void Overlay::set_caps(GstCaps *in, GstCaps *out) {
  GstCaps *drawable = drawable_caps();
  can_draw_ = gst_caps_can_intersect(in, drawable);
  gst_caps_unref(drawable);
  told_of_rows_ = false;
  negotiation_.set_caps(in, out);
}

bool Overlay::can_show(GstCsdTrackOverlay overlay) const {
  if (can_draw_ || overlay != GST_CSD_TRACK_OVERLAY_DRAW) return true;
  GstCaps *caps = gst_pad_get_current_caps(sink_);
  gchar *text = caps ? gst_caps_to_string(caps) : g_strdup("not known");
  GST_ELEMENT_ERROR(element_, STREAM, WRONG_TYPE, ("%s", no_drawing), ("their caps are %s", text));
  g_free(text);
  gst_clear_caps(&caps);
  return false;
}

void Overlay::settle(GstCsdTrackOverlay overlay) {
  if (overlay == GST_CSD_TRACK_OVERLAY_META) negotiation_.settle();
}

void Overlay::show(const GstVideoInfo &info, GstBuffer *buffer, const Tracks &tracks, GstCsdTrackOverlay overlay) {
  if (overlay == GST_CSD_TRACK_OVERLAY_NONE || is_empty_gap(buffer)) return;
  const GstVideoCropMeta *crop = gst_buffer_get_video_crop_meta(buffer);
  if (overlay == GST_CSD_TRACK_OVERLAY_DRAW) {
    if (!can_draw_) throw std::runtime_error(no_drawing);
    MappedFrame frame(info, buffer, GST_MAP_READWRITE);
    if (painter_.draw(*frame, info, crop, tracks) > 0 && !std::exchange(told_of_rows_, true))
      GST_ELEMENT_WARNING(element_, STREAM, FAILED,
                          ("overlay=draw leaves some lines as they are: packing them would change other pixels, for "
                           "they have bits that belong to no sample. Use overlay=meta, or convert the frames before."),
                          ("the format is %s", GST_VIDEO_INFO_NAME(&info)));
  } else if (negotiation_.may_attach()) {
    composition_.attach(buffer, tracks, crop ? static_cast<int>(crop->x) : 0, crop ? static_cast<int>(crop->y) : 0,
                        tracks.height);
  } else if (negotiation_.take_refusal()) {
    GST_ELEMENT_WARNING(element_, STREAM, FAILED,
                        ("Nothing downstream can show an overlay that is not drawn. Use overlay=draw, or a sink that "
                         "renders GstVideoOverlayComposition."),
                        ("the pixels stay as they are"));
  }
}

}  // namespace csd
