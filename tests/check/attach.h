// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <gst/gst.h>

#include <functional>
#include <string>
#include <vector>

#include "meta/csdtrackmeta.h"

namespace csd_check {

using OnBuffer = std::function<void(GstBuffer *buffer, unsigned frame)>;

/// Adds a meta of two features: id 0 at x,y "tracked" and id 7 at 0,0 "lost" and not fresh.
inline void attach(GstBuffer *buffer, const char *source, guint64 frame, int width, int height, double x, double y,
                   const char *name = GST_CSD_TRACK_META_NAME) {
  const GstCsdFeature features[] = {{0, x, y, GST_CSD_STATE_TRACKED, 0.931, TRUE},
                                    {7, 0, 0, GST_CSD_STATE_LOST, 0, FALSE}};
  GstCsdHeader header{};
  header.source = source;
  header.algorithm = "csd-2012";
  header.frame = frame;
  header.width = header.tracked_width = width;
  header.height = header.tracked_height = height;
  header.n_features = 2;
  if (!gst_buffer_add_csd_tracks(buffer, name, &header, features)) g_error("no meta: is the plugin loaded?");
}

/// Whether the element exists. If not, prints that the test is skipped.
inline bool have(const char *factory) {
  GstElementFactory *f = gst_element_factory_find(factory);
  if (f) gst_object_unref(f);
  if (!f) g_printerr("SKIP: there is no %s here\n", factory);
  return f != nullptr;
}

struct Probe {
  OnBuffer call;
  unsigned frame = 0;
};

inline GstPadProbeReturn on_buffer(GstPad *, GstPadProbeInfo *info, gpointer data) {
  auto *probe = static_cast<Probe *>(data);
  GstBuffer *buffer = gst_buffer_make_writable(GST_PAD_PROBE_INFO_BUFFER(info));
  probe->call(buffer, probe->frame++);
  GST_PAD_PROBE_INFO_DATA(info) = buffer;
  return GST_PAD_PROBE_OK;
}

/// Calls `call` with each buffer, made writable, that leaves (`pad` "src") or enters ("sink") the element `name`.
inline void probe(GstElement *pipeline, const char *name, const char *pad, OnBuffer call) {
  GstElement *element = gst_bin_get_by_name(GST_BIN(pipeline), name);
  GstPad *p = gst_element_get_static_pad(element, pad);
  gst_pad_add_probe(p, GST_PAD_PROBE_TYPE_BUFFER, on_buffer, new Probe{std::move(call)},
                    [](gpointer data) { delete static_cast<Probe *>(data); });
  gst_object_unref(p);
  gst_object_unref(element);
}

inline GstElement *launch(const std::string &line) {
  GError *error = nullptr;
  GstElement *pipeline = gst_parse_launch(line.c_str(), &error);
  if (!pipeline || error) g_error("%s: %s", line.c_str(), error ? error->message : "?");
  return pipeline;
}

/// Plays to the end and frees the pipeline. Returns the error message's GError, to be freed, or null after EOS. A
/// pipeline that hangs is ended by check (CK_DEFAULT_TIMEOUT) or by meson, whose set-ups allow for slow sanitizers.
inline GError *play(GstElement *pipeline) {
  gst_element_set_state(pipeline, GST_STATE_PLAYING);
  GstBus *bus = gst_element_get_bus(pipeline);
  GstMessage *message = gst_bus_timed_pop_filtered(bus, GST_CLOCK_TIME_NONE,
                                                   static_cast<GstMessageType>(GST_MESSAGE_EOS | GST_MESSAGE_ERROR));
  GError *error = nullptr;
  if (GST_MESSAGE_TYPE(message) == GST_MESSAGE_ERROR) gst_message_parse_error(message, &error, nullptr);
  gst_message_unref(message);
  gst_element_set_state(pipeline, GST_STATE_NULL);
  gst_object_unref(bus);
  gst_object_unref(pipeline);
  return error;
}

}  // namespace csd_check
