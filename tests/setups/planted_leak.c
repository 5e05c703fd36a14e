/* SPDX-License-Identifier: LGPL-2.1-or-later
 * Leaks one GstBuffer on purpose: proves that the leaks set-up can fail. With an argument it leaks nothing. */
#include <gst/gst.h>

int main(int argc, char **argv) {
  gst_init(NULL, NULL);
  GstBuffer *buffer = gst_buffer_new();
  (void)argv;
  if (argc > 1) gst_buffer_unref(buffer);
  gst_deinit();
  return 0;
}
