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
       * A file of JSON lines (.jsonl) that csdtrackenc wrote. It is read along with the frames and follows seeks. It
       * belongs to the first stream that comes: another one, as in a playlist, gets no tracks, and one WARNING says so.
       * Data on the pad `text` is then ignored.
       *
       * Since: 0.1
       */
      member_property<V, &V::location>(
          g_param_spec_string("location", "Location",
                              "File of JSON lines from csdtrackenc (empty = lines arrive on the pad text)", "", ready)),
      /**
       * GstCsdTrackDec:overlay:
       *
       * How tracks are shown: drawn into the pixels, or as a #GstVideoOverlayComposition beside them. If downstream
       * can't show the latter, the element posts one WARNING and leaves the pixels as they are.
       *
       * Since: 0.1
       */
      overlay,
      /**
       * GstCsdTrackDec:max-wait:
       *
       * A frame waits until the pad `text` has brought its line, a later one, a GAP or EOS. After this time it goes on
       * without tracks, the element posts one WARNING, and no frame waits until text is in time again. Live, every
       * frame waits, but no longer than the latency in the answer to the LATENCY query.
       *
       * Since: 0.1
       */
      member_property<V, &V::live, &L::max_wait>(
          g_param_spec_uint64("max-wait", "Maximum wait",
                              "How many nanoseconds a frame waits for its line from the pad text before it goes on "
                              "without (0 = it never waits)",
                              0, G_MAXINT64, L().max_wait, playing)),
      /**
       * GstCsdTrackDec:ts-offset:
       *
       * Added to the time of each line. Use it when a part of a recording plays on its own from 0, while its lines have
       * the time of the whole: set it to minus the time at which the part begins.
       *
       * Since: 0.1
       */
      member_property<V, &V::live, &L::ts_offset>(g_param_spec_int64("ts-offset", "Timestamp offset",
                                                                     "Nanoseconds to add to the time of each line",
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
