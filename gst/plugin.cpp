// SPDX-License-Identifier: LGPL-2.1-or-later
#include "elements/csdsimsrc.h"
#include "elements/csdtrack.h"
#include "elements/csdtrackdec.h"
#include "elements/csdtrackenc.h"
#include "meta/meta.h"
#include "support/enums.h"

namespace {

void mark_plugin_api() {
  for (const GType type : {GST_TYPE_CSD_TRACK_ALGORITHM, GST_TYPE_CSD_TRACK_CONTENT_AREA, GST_TYPE_CSD_TRACK_LEARNING,
                           GST_TYPE_CSD_TRACK_OVERLAY, GST_TYPE_CSD_TRACK_POST_MESSAGES, GST_TYPE_CSD_TRACK_ON_ERROR,
                           GST_TYPE_CSD_TRACK_ENC_ROLE, GST_TYPE_CSD_SIM_SCENARIO, GST_TYPE_CSD_SIM_STYLE})
    gst_type_mark_as_plugin_api(type, static_cast<GstPluginAPIFlags>(0));
}

gboolean plugin_init(GstPlugin *plugin) {
  if (!csd::register_track_metas()) return FALSE;
  mark_plugin_api();
  return GST_ELEMENT_REGISTER(csdtrack, plugin) && GST_ELEMENT_REGISTER(csdtrackdec, plugin) &&
         GST_ELEMENT_REGISTER(csdtrackenc, plugin) && GST_ELEMENT_REGISTER(csdsimsrc, plugin);
}

}  // namespace

GST_PLUGIN_DEFINE(GST_VERSION_MAJOR, GST_VERSION_MINOR, csdtrack, "Tracking of deforming tissue in endoscopic video",
                  plugin_init, PACKAGE_VERSION, "LGPL", PACKAGE, PACKAGE)
