/* SPDX-License-Identifier: LGPL-2.1-or-later
 * planted-fault none|leak|read|overflow|crash: proves that the set-ups can fail. On purpose it leaks a GstBuffer, reads
 * beyond the end of an array, overflows an integer or dies by a signal. */
#include <gst/gst.h>
#include <limits.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

int main(int argc, char **argv) {
  const char *fault = argc > 1 ? argv[1] : "none";
  gst_init(NULL, NULL);
  GstBuffer *buffer = gst_buffer_new();
  if (strcmp(fault, "leak") != 0) gst_buffer_unref(buffer);
  if (strcmp(fault, "read") == 0) {
    volatile char *array = malloc((size_t)argc);
    array[0] = array[argc];
    free((void *)array);
  }
  if (strcmp(fault, "overflow") == 0) {
    volatile int most = INT_MAX;
    most = most + argc;
  }
  if (strcmp(fault, "crash") == 0) {
    fputs("a planted crash\n", stderr);
    abort();
  }
  gst_deinit();
  return 0;
}
