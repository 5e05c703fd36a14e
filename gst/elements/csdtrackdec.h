// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <gst/base/gstaggregator.h>

G_BEGIN_DECLS

#define GST_TYPE_CSD_TRACK_DEC (gst_csd_track_dec_get_type())
G_DECLARE_FINAL_TYPE(GstCsdTrackDec, gst_csd_track_dec, GST, CSD_TRACK_DEC, GstAggregator)

GST_ELEMENT_REGISTER_DECLARE(csdtrackdec)

G_END_DECLS
