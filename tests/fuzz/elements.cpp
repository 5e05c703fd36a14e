// SPDX-License-Identifier: LGPL-2.1-or-later
#include "elements.h"

#include <gst/video/navigation.h>

#include <algorithm>
#include <cstring>
#include <opencv2/core/utility.hpp>

#include "elements/csdsimsrc.h"
#include "elements/csdtrack.h"
#include "elements/csdtrackdec.h"
#include "elements/csdtrackenc.h"
#include "meta/csdtrackmeta.h"

namespace csd_fuzz {
namespace {

/// Reads the metadata as a downstream element does.
void read_tracks(GstBuffer *buffer) {
  for (const char *name : {GST_CSD_TRACK_META_NAME, GST_CSD_TRUTH_META_NAME}) {
    GstCsdHeader header;
    const GstStructure *tracks = gst_buffer_get_csd_tracks(buffer, name, nullptr);
    if (!tracks || !gst_csd_structure_get_header(tracks, &header)) continue;
    GstCsdFeature feature;
    for (guint i = 0; i < header.n_features; ++i) gst_csd_structure_get_feature(tracks, i, &feature);
  }
}

GstFlowReturn chain(GstPad *, GstObject *, GstBuffer *buffer) {
  read_tracks(buffer);
  gst_buffer_unref(buffer);
  return GST_FLOW_OK;
}

/// Forwards an EOS to the bus, for wait().
gboolean event(GstPad *pad, GstObject *, GstEvent *event) {
  if (GST_EVENT_TYPE(event) == GST_EVENT_EOS)
    gst_bus_post(GST_BUS(g_object_get_data(G_OBJECT(pad), "bus")), gst_message_new_eos(nullptr));
  gst_event_unref(event);
  return TRUE;
}

gboolean query(GstPad *pad, GstObject *parent, GstQuery *query) {
  const auto *downstream = static_cast<GstCaps *>(g_object_get_data(G_OBJECT(pad), "caps"));
  if (GST_QUERY_TYPE(query) == GST_QUERY_ALLOCATION) {
    const auto *rig = static_cast<const Rig *>(g_object_get_data(G_OBJECT(pad), "rig"));
    if (rig->renders_compositions)
      gst_query_add_allocation_meta(query, GST_VIDEO_OVERLAY_COMPOSITION_META_API_TYPE, nullptr);
    return TRUE;
  }
  if (GST_QUERY_TYPE(query) == GST_QUERY_CAPS && downstream) {
    GstCaps *filter = nullptr;
    gst_query_parse_caps(query, &filter);
    GstCaps *caps = filter ? gst_caps_intersect(const_cast<GstCaps *>(downstream), filter) : gst_caps_copy(downstream);
    gst_query_set_caps_result(query, caps);
    gst_caps_unref(caps);
    return TRUE;
  }
  return gst_pad_query_default(pad, parent, query);
}

GstSegment segment(Numbers &from) {
  GstSegment segment;
  gst_segment_init(&segment, one_in(from, 6) ? GST_FORMAT_BYTES : GST_FORMAT_TIME);
  segment.rate = pick(from, {1.0, 2.0, 0.1, -1.0});
  segment.start = from.ConsumeIntegralInRange<guint64>(0, 10 * GST_SECOND);
  segment.time = one_in(from, 4) ? from.ConsumeIntegral<guint64>() : segment.start;
  segment.base = one_in(from, 4) ? from.ConsumeIntegral<guint64>() : 0;
  if (segment.rate < 0 || one_in(from, 4)) segment.stop = segment.start + GST_SECOND;
  return segment;
}

GstEvent *navigation(Numbers &from) {
  const double x = pick(from, {0.0, 20.5, -3.0, 1e300, G_MAXDOUBLE}), y = from.ConsumeFloatingPoint<double>();
  switch (choose(from, 3)) {
    case 0:
      return gst_navigation_event_new_key_press(one_in(from, 2) ? "r" : text(from).c_str(),
                                                GST_NAVIGATION_MODIFIER_NONE);
    case 1:
      return gst_navigation_event_new_mouse_move(x, y, GST_NAVIGATION_MODIFIER_NONE);
    default:
      return gst_navigation_event_new_mouse_button_press(static_cast<gint>(choose(from, 4)), x, y,
                                                         GST_NAVIGATION_MODIFIER_NONE);
  }
}

}  // namespace

void start() {
  // Without system plugins and registry: the elements are linked in.
  for (const char *name : {"GST_PLUGIN_PATH_1_0", "GST_PLUGIN_SYSTEM_PATH_1_0"}) g_setenv(name, "", TRUE);
  g_setenv("GST_REGISTRY_DISABLE", "yes", TRUE);
  gst_init(nullptr, nullptr);
  expect(gst_element_register_csdtrack(nullptr) && gst_element_register_csdtrackdec(nullptr) &&
         gst_element_register_csdtrackenc(nullptr) && gst_element_register_csdsimsrc(nullptr));
  cv::setNumThreads(1);  // with OpenCV's threads, no two runs would be the same
}

void set_property(Numbers &from, GstElement *element) {
  guint count = 0;
  GParamSpec **specs = g_object_class_list_properties(G_OBJECT_GET_CLASS(element), &count);
  const GParamSpec *spec = specs[choose(from, std::min(count, 256u) - 1)];
  g_free(specs);
  // GstObject's own properties, and one that would look for plugins.
  static const std::string others[] = {"name", "parent", "typefind"};
  if (!(spec->flags & G_PARAM_WRITABLE) ||
      std::find(std::begin(others), std::end(others), spec->name) != std::end(others))
    return;
  GValue value = G_VALUE_INIT;
  g_value_init(&value, spec->value_type);
  if (const auto *u = G_IS_PARAM_SPEC_UINT(spec) ? G_PARAM_SPEC_UINT(spec) : nullptr) {
    // More threads cost time and find nothing more.
    const guint most = std::strcmp(spec->name, "n-threads") == 0 ? 3 : u->maximum;
    g_value_set_uint(&value, from.ConsumeIntegralInRange(u->minimum, most));
  } else if (const auto *u64 = G_IS_PARAM_SPEC_UINT64(spec) ? G_PARAM_SPEC_UINT64(spec) : nullptr) {
    // A frame would wait max-wait for its text. GstAggregator's range of latency contains GST_CLOCK_TIME_NONE, but its
    // setter refuses that as a programmer's error.
    guint64 most = std::strcmp(spec->name, "max-wait") == 0 ? GST_MSECOND : u64->maximum;
    if (std::strcmp(spec->name, "latency") == 0) most = GST_CLOCK_TIME_NONE - 1;
    g_value_set_uint64(&value, from.ConsumeIntegralInRange(u64->minimum, most));
  } else if (const auto *i = G_IS_PARAM_SPEC_INT(spec) ? G_PARAM_SPEC_INT(spec) : nullptr) {
    g_value_set_int(&value, from.ConsumeIntegralInRange(i->minimum, i->maximum));
  } else if (const auto *i64 = G_IS_PARAM_SPEC_INT64(spec) ? G_PARAM_SPEC_INT64(spec) : nullptr) {
    g_value_set_int64(&value, from.ConsumeIntegralInRange(i64->minimum, i64->maximum));
  } else if (const auto *d = G_IS_PARAM_SPEC_DOUBLE(spec) ? G_PARAM_SPEC_DOUBLE(spec) : nullptr) {
    g_value_set_double(&value, from.ConsumeFloatingPointInRange(d->minimum, d->maximum));
  } else if (G_IS_PARAM_SPEC_BOOLEAN(spec)) {
    g_value_set_boolean(&value, from.ConsumeBool());
  } else if (const auto *e = G_IS_PARAM_SPEC_ENUM(spec) ? G_PARAM_SPEC_ENUM(spec) : nullptr) {
    g_value_set_enum(&value, e->enum_class->values[choose(from, e->enum_class->n_values - 1)].value);
  } else if (G_IS_PARAM_SPEC_STRING(spec)) {
    g_value_set_string(&value, one_in(from, 16) ? nullptr : text(from).c_str());
  }
  g_object_set_property(G_OBJECT(element), spec->name, &value);
  g_value_unset(&value);
}

void get_properties(GstElement *element) {
  guint count = 0;
  GParamSpec **specs = g_object_class_list_properties(G_OBJECT_GET_CLASS(element), &count);
  for (guint i = 0; i < count; ++i) {
    if (!(specs[i]->flags & G_PARAM_READABLE)) continue;
    GValue value = G_VALUE_INIT;
    g_value_init(&value, specs[i]->value_type);
    g_object_get_property(G_OBJECT(element), specs[i]->name, &value);
    g_value_unset(&value);
  }
  g_free(specs);
}

// ---- Rig -----------------------------------------------------------------------------------------------------------

Rig::Rig(const char *factory, GstCaps *downstream)
    : element_(GST_ELEMENT(gst_object_ref_sink(gst_element_factory_make(factory, nullptr)))), bus_(gst_bus_new()) {
  gst_element_set_bus(element_, bus_);
  const auto add = [&](const char *name, GstPadDirection direction) -> GstPad * {
    GstPad *peer = gst_element_get_static_pad(element_, name);
    if (!peer) return nullptr;
    GstPad *pad = gst_pad_new("ours", direction);
    gst_object_ref_sink(pad);
    if (direction == GST_PAD_SRC) {
      gst_pad_link_full(pad, peer, GST_PAD_LINK_CHECK_NOTHING);
    } else {
      g_object_set_data(G_OBJECT(pad), "bus", bus_);
      g_object_set_data(G_OBJECT(pad), "rig", this);
      g_object_set_data_full(G_OBJECT(pad), "caps", downstream, [](gpointer caps) {
        if (caps) gst_caps_unref(GST_CAPS(caps));
      });
      gst_pad_set_chain_function(pad, chain);
      gst_pad_set_event_function(pad, event);
      gst_pad_set_query_function(pad, query);
      gst_pad_link_full(peer, pad, GST_PAD_LINK_CHECK_NOTHING);
    }
    gst_object_unref(peer);
    gst_pad_set_active(pad, TRUE);
    return pad;
  };
  src_ = add("sink", GST_PAD_SRC);
  sink_ = add("src", GST_PAD_SINK);
}

Rig::~Rig() {
  gst_element_set_state(element_, GST_STATE_NULL);
  for (GstPad *pad : {src_, sink_}) {
    if (!pad) continue;
    gst_pad_set_active(pad, FALSE);
    if (GstPad *peer = gst_pad_get_peer(pad)) {
      pad == src_ ? gst_pad_unlink(pad, peer) : gst_pad_unlink(peer, pad);
      gst_object_unref(peer);
    }
    gst_object_unref(pad);
  }
  read_messages();
  gst_element_set_bus(element_, nullptr);
  gst_bus_set_flushing(bus_, TRUE);
  gst_object_unref(bus_);
  gst_object_unref(element_);
  if (caps_) gst_caps_unref(caps_);
}

/// Each text must be readable by a binding, which needs UTF-8.
void Rig::read_messages() {
  while (GstMessage *message = gst_bus_pop(bus_)) {
    GError *error = nullptr;
    gchar *debug = nullptr;
    if (GST_MESSAGE_TYPE(message) == GST_MESSAGE_ERROR) gst_message_parse_error(message, &error, &debug);
    if (GST_MESSAGE_TYPE(message) == GST_MESSAGE_WARNING) gst_message_parse_warning(message, &error, &debug);
    if (error) expect(is_utf8(error->message) && (!debug || is_utf8(debug)));
    g_clear_error(&error);
    g_free(debug);
    gst_message_unref(message);
  }
}

void Rig::wait() {
  const auto kinds = static_cast<GstMessageType>(GST_MESSAGE_EOS | GST_MESSAGE_ERROR);
  if (GstMessage *message = gst_bus_timed_pop_filtered(bus_, 15 * GST_SECOND, kinds)) {
    gst_message_unref(message);
    return;
  }
  std::abort();
}

void Rig::set_state(GstState state) {
  const GstState before = GST_STATE(element_);
  gst_element_set_state(element_, state);
  // Inactive pads have forgotten their sticky events.
  if (before <= GST_STATE_READY && state > GST_STATE_READY) begin();
}

void Rig::begin() {
  if (!src_) return;
  gst_pad_set_active(src_, FALSE);
  gst_pad_set_active(src_, TRUE);
  push(gst_event_new_stream_start("a"));
  if (caps_) push(gst_event_new_caps(caps_));
  GstSegment usual;
  gst_segment_init(&usual, GST_FORMAT_TIME);
  push(gst_event_new_segment(&usual));
}

void Rig::set_caps(GstCaps *caps) {
  if (caps_) gst_caps_unref(caps_);
  caps_ = caps;
  push(gst_event_new_caps(caps));
}

GstFlowReturn Rig::push(GstBuffer *buffer) {
  return gst_pad_push(src_, buffer);
}

bool Rig::push(GstEvent *event) {
  return gst_pad_push_event(src_, event);
}

bool Rig::push_upstream(GstEvent *event) {
  return gst_pad_push_event(sink_, event);
}

void Rig::some_event(Numbers &from, unsigned index) {
  const GstClockTime now = index * 40 * GST_MSECOND;
  switch (choose(from, 9)) {
    case 0: {
      push(gst_event_new_flush_start());
      push(gst_event_new_flush_stop(TRUE));
      GstSegment usual;
      gst_segment_init(&usual, GST_FORMAT_TIME);
      if (!one_in(from, 8)) push(gst_event_new_segment(&usual));
      break;
    }
    case 1: {
      const GstSegment other = segment(from);
      push(gst_event_new_segment(&other));
      break;
    }
    case 2:
      push(gst_event_new_gap(one_in(from, 4) ? from.ConsumeIntegralInRange<guint64>(0, G_MAXUINT64 - 1) : now,
                             one_in(from, 4) ? GST_CLOCK_TIME_NONE : 40 * GST_MSECOND));
      break;
    case 3:
      push(gst_event_new_eos());
      break;
    case 4:
      push(gst_event_new_stream_start(one_in(from, 2) ? "a" : "b"));
      break;
    case 5: {
      GstTagList *tags = gst_tag_list_new(GST_TAG_TITLE, "title", nullptr);
      gst_tag_list_set_scope(tags, one_in(from, 2) ? GST_TAG_SCOPE_GLOBAL : GST_TAG_SCOPE_STREAM);
      push(gst_event_new_tag(tags));
      break;
    }
    case 6:
      push_upstream(gst_event_new_reconfigure());
      break;
    case 7:
      push_upstream(gst_event_new_qos(GST_QOS_TYPE_UNDERFLOW, 2, static_cast<GstClockTimeDiff>(now), now));
      break;
    case 8:
      push(gst_event_new_custom(GST_EVENT_CUSTOM_DOWNSTREAM, gst_structure_new_empty("any")));
      break;
    default:
      push_upstream(navigation(from));
  }
}

void Rig::some_query(Numbers &from) {
  GstQuery *query = nullptr;
  GstCaps *caps = video_caps(from, true);
  switch (choose(from, 3)) {
    case 0:
      query = gst_query_new_caps(one_in(from, 2) ? caps : nullptr);
      break;
    case 1:
      query = gst_query_new_accept_caps(caps);
      break;
    case 2:
      query = gst_query_new_allocation(one_in(from, 8) ? nullptr : caps, TRUE);
      break;
    default:
      query = gst_query_new_latency();
  }
  GstPad *pad = src_ && one_in(from, 2) ? src_ : sink_;
  gst_pad_peer_query(pad, query);
  gst_query_unref(query);
  gst_caps_unref(caps);
}

}  // namespace csd_fuzz
