// SPDX-License-Identifier: LGPL-2.1-or-later
// GStreamer's header, with what csdtrack uses of 1.28's matrix transform, for tests on machines with an older one.
#pragma once
#pragma GCC system_header  // which may say include_next

#include_next <gst/video/video.h>

#ifndef GST_VIDEO_META_TRANSFORM_IS_MATRIX
struct GstVideoMetaTransformMatrix {
  const GstVideoInfo *in_info;
  GstVideoRectangle in_rectangle;
  const GstVideoInfo *out_info;
  GstVideoRectangle out_rectangle;
  gfloat matrix[3][3];
};

inline GQuark gst_video_meta_transform_matrix_get_quark() {
  return g_quark_from_static_string("gst-video-matrix");
}
#define GST_VIDEO_META_TRANSFORM_IS_MATRIX(type) ((type) == gst_video_meta_transform_matrix_get_quark())
#endif
