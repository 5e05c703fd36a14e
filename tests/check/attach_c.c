/* SPDX-License-Identifier: LGPL-2.1-or-later */
/* Uses the header from C11. Called by test_read_meta.py. */
#include "meta/csdtrackmeta.h"

gboolean csd_check_attach(GstBuffer *buffer);

gboolean csd_check_attach(GstBuffer *buffer) {
  const GstCsdFeature features[] = {
      {0, 1.5, -2.25, GST_CSD_STATE_TRACKED, 0.5, TRUE},
      {4294967294u, 0, 0, GST_CSD_STATE_LOST, 0, FALSE},
  };
  const GstCsdHeader header = {"csdtrack0", "csd-2012", G_GUINT64_CONSTANT(5000000000), 64, 48, 128, 96, 2};

  return gst_buffer_add_csd_tracks(buffer, GST_CSD_TRACK_META_NAME, &header, features) != NULL;
}
