// SPDX-License-Identifier: LGPL-2.1-or-later
#include "support/dec_properties.h"

#include <gst/base/gstaggregator.h>

#include "caps/formats.h"
#include "overlay/overlay.h"

namespace csd {

namespace {

constexpr gint64 max_offset = 1000000000 * gint64{GST_SECOND};  // 31 years, so sums don't overflow

GstStaticPadTemplate text_template =
    GST_STATIC_PAD_TEMPLATE("text", GST_PAD_SINK, GST_PAD_REQUEST,
                            GST_STATIC_CAPS("application/x-ndjson; text/x-raw, format=(string){ utf8, pango-markup }; "
                                            "meta/x-klv"));

}  // namespace

std::vector<Property<DecValues>> dec_properties(void (*overlay_changed)(gpointer)) {
  constexpr auto flags = static_cast<GParamFlags>(G_PARAM_READWRITE | G_PARAM_STATIC_STRINGS);
  constexpr auto ready = static_cast<GParamFlags>(flags | GST_PARAM_MUTABLE_READY);
  constexpr auto playing = static_cast<GParamFlags>(flags | GST_PARAM_MUTABLE_PLAYING);
  using V = DecValues;
  using L = DecLive;
  auto overlay = member_property<V, &V::live, &L::overlay>(Overlay::param_spec());
  overlay.changed = overlay_changed;
  return {
      /**
       * GstCsdTrackDec:location:
       *
       * Since: 0.1
       */
      member_property<V, &V::location>(g_param_spec_string(
          "location", "Location",
          "A file of JSON lines (.jsonl) from csdtrackenc. It is read along with the frames and follows "
          "seeks. It belongs to the first stream that comes: another one, as in a playlist, gets no tracks,"
          " and one WARNING says so. The pad text is then not read (one WARNING). Empty: lines come on that"
          " pad",
          "", ready)),
      /**
       * GstCsdTrackDec:overlay:
       *
       * Since: 0.1
       */
      overlay,
      /**
       * GstCsdTrackDec:max-wait:
       *
       * Since: 0.1
       */
      member_property<V, &V::live, &L::max_wait>(g_param_spec_uint64(
          "max-wait", "Maximum wait",
          "How many nanoseconds a frame waits until the pad text has brought its line, a later one, a GAP "
          "or EOS. Then it goes on without tracks, with one WARNING, and no frame waits until text is in "
          "time again. Live, each frame waits, but no longer than the latency. 0: no wait, and no warning",
          0, G_MAXINT64, L().max_wait, playing)),
      /**
       * GstCsdTrackDec:ts-offset:
       *
       * Since: 0.1
       */
      member_property<V, &V::live, &L::ts_offset>(g_param_spec_int64(
          "ts-offset", "Timestamp offset",
          "Nanoseconds added to the time of each line. A part of a recording that plays on its own from 0 "
          "needs minus the time at which it begins",
          -max_offset, max_offset, 0, playing)),
  };
}

void add_dec_pad_templates(GstElementClass *klass) {
  GstCaps *caps = any_memory_caps();
  gst_element_class_add_pad_template(
      klass, gst_pad_template_new_with_gtype("sink", GST_PAD_SINK, GST_PAD_ALWAYS, caps, GST_TYPE_AGGREGATOR_PAD));
  gst_element_class_add_pad_template(
      klass, gst_pad_template_new_with_gtype("src", GST_PAD_SRC, GST_PAD_ALWAYS, caps, GST_TYPE_AGGREGATOR_PAD));
  gst_caps_unref(caps);
  gst_element_class_add_static_pad_template_with_gtype(klass, &text_template, GST_TYPE_AGGREGATOR_PAD);
}

}  // namespace csd
