// SPDX-License-Identifier: LGPL-2.1-or-later
// Pictures, harnesses and metadata for the tests of csdtrack.
#pragma once

#include <gst/check/gstcheck.h>
#include <gst/check/gstharness.h>
#include <gst/video/video.h>

#include <cmath>
#include <cstring>
#include <map>
#include <string>

#include "meta/csdtrackmeta.h"

inline constexpr char gray_320[] = "video/x-raw,format=GRAY8,width=320,height=240,framerate=25/1";

/// A picture with texture everywhere: squares of 16 pixels, with a hash of their place as brightness.
inline guint8 texture(int x, int y) {
  guint32 h = static_cast<guint32>(x / 16) * 2654435761u ^ static_cast<guint32>(y / 16) * 40503u;
  h ^= h >> 13;
  h *= 0x5bd1e995u;
  return static_cast<guint8>(40 + (h >> 24) % 160);
}

inline GstBuffer *picture(int width, int height, int index, guint8 (*value)(int, int) = texture) {
  const int stride = GST_ROUND_UP_4(width);
  GstBuffer *buffer = gst_buffer_new_allocate(nullptr, static_cast<gsize>(stride) * height, nullptr);
  GstMapInfo map;
  gst_buffer_map(buffer, &map, GST_MAP_WRITE);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) map.data[y * stride + x] = value(x, y);
  gst_buffer_unmap(buffer, &map);
  GST_BUFFER_PTS(buffer) = index * 40 * GST_MSECOND;
  GST_BUFFER_DURATION(buffer) = 40 * GST_MSECOND;
  return buffer;
}

inline GstHarness *harness(const char *launch, const char *caps = gray_320) {
  GstHarness *h = gst_harness_new_parse(launch);
  gst_harness_set_src_caps_str(h, caps);
  return h;
}

/// The bin of gst_harness_new_parse() has one child. The caller owns a reference.
inline GstElement *element(GstHarness *h) {
  return GST_ELEMENT(gst_object_ref(GST_IS_BIN(h->element) ? GST_BIN(h->element)->children->data : h->element));
}

inline std::map<guint, std::string> states(GstBuffer *buffer) {
  std::map<guint, std::string> result;
  const GstStructure *s = gst_buffer_get_csd_tracks(buffer, GST_CSD_TRACK_META_NAME, nullptr);
  fail_unless(s != nullptr);
  GstCsdHeader header;
  fail_unless(gst_csd_structure_get_header(s, &header));
  for (guint i = 0; i < header.n_features; ++i) {
    GstCsdFeature f;
    fail_unless(gst_csd_structure_get_feature(s, i, &f));
    fail_unless(std::isfinite(f.x) && std::isfinite(f.y) && f.confidence >= 0 && f.confidence <= 1);
    result[f.id] = f.state;
  }
  return result;
}

inline guint64 frame_number(GstBuffer *buffer) {
  GstCsdHeader header;
  fail_unless(
      gst_csd_structure_get_header(gst_buffer_get_csd_tracks(buffer, GST_CSD_TRACK_META_NAME, nullptr), &header));
  return header.frame;
}

/// Pushes a frame and returns the states on the frame that comes out.
inline std::map<guint, std::string> push(GstHarness *h, GstBuffer *in) {
  GstBuffer *out = gst_harness_push_and_pull(h, in);
  fail_unless(out != nullptr);
  auto result = states(out);
  gst_buffer_unref(out);
  return result;
}
