// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <gst/gst.h>

G_BEGIN_DECLS

#define GST_TYPE_CSD_TRACK_ENC (gst_csd_track_enc_get_type())
G_DECLARE_FINAL_TYPE(GstCsdTrackEnc, gst_csd_track_enc, GST, CSD_TRACK_ENC, GstElement)

GST_ELEMENT_REGISTER_DECLARE(csdtrackenc)

G_END_DECLS
