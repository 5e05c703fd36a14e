// SPDX-License-Identifier: LGPL-2.1-or-later
#include <gst/gst.h>

#include "csdtrackenc.h"
#include "meta.h"

#define PACKAGE "csdtrack"

static gboolean plugin_init(GstPlugin *plugin) {
  return csd::register_track_metas() && GST_ELEMENT_REGISTER(csdtrackenc, plugin);
}

GST_PLUGIN_DEFINE(GST_VERSION_MAJOR, GST_VERSION_MINOR, csdtrack, "Tracks points on deforming tissue", plugin_init,
                  "0.1.0", "LGPL", "csdtrack", "csdtrack")
