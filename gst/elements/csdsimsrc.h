// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <gst/base/gstpushsrc.h>
#include <gst/gst.h>

G_BEGIN_DECLS

#define GST_TYPE_CSD_SIM_SRC (gst_csd_sim_src_get_type())
G_DECLARE_FINAL_TYPE(GstCsdSimSrc, gst_csd_sim_src, GST, CSD_SIM_SRC, GstPushSrc)

GST_ELEMENT_REGISTER_DECLARE(csdsimsrc)

G_END_DECLS
