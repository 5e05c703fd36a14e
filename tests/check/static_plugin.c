/* SPDX-License-Identifier: LGPL-2.1-or-later */
/* A program in C with the plugin linked in. It runs a pipeline of three of its elements, and finds the fourth. */
#include <gst/gst.h>

GST_PLUGIN_STATIC_DECLARE(csdtrack);

int main(int argc, char **argv) {
  gst_init(&argc, &argv);
  GstElementFactory *factory = gst_element_factory_find("csdtrack");
  if (factory != NULL) g_error("csdtrack is there before it is registered");
  GST_PLUGIN_STATIC_REGISTER(csdtrack);

  GstPlugin *plugin = gst_registry_find_plugin(gst_registry_get(), "csdtrack");
  if (plugin == NULL) g_error("no plugin");
  if (gst_plugin_get_filename(plugin) != NULL) g_error("loaded from %s", gst_plugin_get_filename(plugin));
  gst_object_unref(plugin);
  factory = gst_element_factory_find("csdtrackdec");
  if (factory == NULL) g_error("no csdtrackdec");
  gst_object_unref(factory);

  GError *error = NULL;
  GstElement *pipeline = gst_parse_launch(
      "csdsimsrc num-buffers=3 ! video/x-raw,width=160,height=120 ! csdtrack ! csdtrackenc ! fakesink name=sink",
      &error);
  if (error != NULL) g_error("%s", error->message);
  gst_element_set_state(pipeline, GST_STATE_PLAYING);
  GstBus *bus = gst_element_get_bus(pipeline);
  GstMessage *message = gst_bus_timed_pop_filtered(bus, 60 * GST_SECOND, GST_MESSAGE_EOS | GST_MESSAGE_ERROR);
  if (message == NULL || GST_MESSAGE_TYPE(message) != GST_MESSAGE_EOS) g_error("no EOS");
  gst_message_unref(message);
  GstElement *sink = gst_bin_get_by_name(GST_BIN(pipeline), "sink");
  GstSample *last = NULL;
  g_object_get(sink, "last-sample", &last, NULL);
  if (last == NULL || gst_buffer_get_size(gst_sample_get_buffer(last)) < 100) g_error("no line of tracks");
  gst_sample_unref(last);
  gst_object_unref(sink);
  gst_element_set_state(pipeline, GST_STATE_NULL);
  gst_object_unref(bus);
  gst_object_unref(pipeline);
  gst_deinit(); /* the leaks tracer reports in it */
  return 0;
}
