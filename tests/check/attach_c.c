/* SPDX-License-Identifier: LGPL-2.1-or-later */
/* Uses the header from C11. Called by test_read_meta.py. */
#include "meta/csdtrackmeta.h"

/* The version is meson's: CSDTRACK_VERSION is its three numbers. */
#define EQUALS(major, minor, micro)                                                  \
  (GST_CSD_META_VERSION_MAJOR == (major) && GST_CSD_META_VERSION_MINOR == (minor) && \
   GST_CSD_META_VERSION_MICRO == (micro))
#define EQUALS_ALL(...) EQUALS(__VA_ARGS__)
G_STATIC_ASSERT(EQUALS_ALL(CSDTRACK_VERSION));

#define AT_LEAST(d_major, d_minor, d_micro)                                                                  \
  GST_CSD_META_CHECK_VERSION(GST_CSD_META_VERSION_MAJOR + (d_major), GST_CSD_META_VERSION_MINOR + (d_minor), \
                             GST_CSD_META_VERSION_MICRO + (d_micro))
#if !AT_LEAST(0, 0, 0) || !AT_LEAST(0, 0, -1) || !AT_LEAST(0, -1, 9) || !AT_LEAST(-1, 9, 9)
#error "the version is at least its own, and at least an earlier one"
#endif
#if AT_LEAST(0, 0, 1) || AT_LEAST(0, 1, -9) || AT_LEAST(1, -9, -9)
#error "the version is not a later one"
#endif

gboolean csd_check_attach(GstBuffer *buffer);

gboolean csd_check_attach(GstBuffer *buffer) {
  const GstCsdFeature features[] = {
      {0, 1.5, -2.25, GST_CSD_STATE_TRACKED, 0.5, TRUE},
      {4294967294u, 0, 0, GST_CSD_STATE_LOST, 0, FALSE},
  };
  const GstCsdHeader header = {"csdtrack0", "csd-2012", G_GUINT64_CONSTANT(5000000000), 64, 48, 128, 96, 2};

  return gst_buffer_add_csd_tracks(buffer, GST_CSD_TRACK_META_NAME, &header, features) != NULL;
}
