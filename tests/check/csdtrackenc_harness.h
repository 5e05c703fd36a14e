// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <gst/check/gstharness.h>

#include "attach.h"
#include "read_text.h"

namespace csd_check {

inline constexpr char video_caps[] = "video/x-raw,format=I420,width=64,height=48,framerate=25/1";
inline constexpr GstClockTime frame_time = 40 * GST_MSECOND;

/// csdtrackenc between two pads.
struct Harness {
  GstHarness *h = gst_harness_new("csdtrackenc");
  explicit Harness(const char *out = nullptr, const char *in = video_caps) {
    if (out) gst_harness_set_sink_caps_str(h, out);
    gst_harness_set_src_caps_str(h, in);
  }
  ~Harness() { gst_harness_teardown(h); }
  GstFlowReturn push(GstBuffer *frame) { return gst_harness_push(h, frame); }
  std::string pull(GstBuffer **kept = nullptr) {
    GstBuffer *buffer = gst_harness_pull(h);
    std::string text = text_in(buffer);
    if (kept)
      *kept = buffer;
    else
      gst_buffer_unref(buffer);
    return text;
  }
};

/// Frame n of 25 a second.
inline GstBuffer *frame(guint64 n) {
  GstBuffer *buffer = gst_buffer_new_allocate(nullptr, 64 * 48 * 3 / 2, nullptr);
  GST_BUFFER_PTS(buffer) = n * frame_time;
  GST_BUFFER_DURATION(buffer) = frame_time;
  return buffer;
}

/// The same with two features.
inline GstBuffer *tracked_frame(guint64 n, const char *source = "csdtrack0") {
  GstBuffer *buffer = frame(n);
  attach(buffer, source, n + 12, 64, 48, 31.2044, -0.0001);
  return buffer;
}

/// fail_unless_equals_string() only keeps the pointer, which a temporary would leave dangling.
inline void assert_text(const std::string &text, const std::string &expected) {
  fail_unless_equals_string(text.c_str(), expected.c_str());
}

}  // namespace csd_check
