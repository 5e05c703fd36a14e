// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <gst/video/gstvideofilter.h>
#include <gst/video/video.h>

G_BEGIN_DECLS

#define GST_TYPE_CSD_TRACK (gst_csd_track_get_type())
G_DECLARE_FINAL_TYPE(GstCsdTrack, gst_csd_track, GST, CSD_TRACK, GstVideoFilter)

GST_ELEMENT_REGISTER_DECLARE(csdtrack)

G_END_DECLS
