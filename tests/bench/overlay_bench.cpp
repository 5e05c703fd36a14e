// SPDX-License-Identifier: LGPL-2.1-or-later
// The cost of a frame's overlay: 100 features at 1280×720 in all drawn states, with ids of three digits.
#include <benchmark/benchmark.h>

#include <cstring>

#include "overlay/overlay_composition.h"
#include "overlay/overlay_painter.h"

namespace {

csd::Tracks hundred(int width, int height) {
  csd::Tracks tracks;
  tracks.width = width, tracks.height = height;
  for (unsigned i = 0; i < 100; ++i) {
    csd::Feature f;
    f.id = 100 + i;
    f.x = (i % 10 + 0.5) * width / 10, f.y = (i / 10 + 0.5) * height / 10;
    f.state = static_cast<csd::FeatureState>(i % 10 < 6 ? 1 : i % 5);  // most are tracked
    tracks.features.push_back(f);
  }
  return tracks;
}

void draw(benchmark::State &state, const char *format) {
  gst_init(nullptr, nullptr);
  GstVideoInfo info;
  gst_video_info_set_format(&info, gst_video_format_from_string(format), 1280, 720);
  GstBuffer *buffer = gst_buffer_new_allocate(nullptr, info.size, nullptr);
  gst_buffer_memset(buffer, 0, 0x50, info.size);
  GstVideoFrame frame;
  gst_video_frame_map(&frame, &info, buffer, GST_MAP_READWRITE);
  const csd::Tracks tracks = hundred(1280, 720);
  csd::OverlayPainter painter;
  painter.draw(frame, info, nullptr, tracks);  // makes the sprites, once
  for (auto _ : state) {
    painter.draw(frame, info, nullptr, tracks);
    benchmark::ClobberMemory();
  }
  gst_video_frame_unmap(&frame);
  gst_buffer_unref(buffer);
}

void attach(benchmark::State &state) {
  gst_init(nullptr, nullptr);
  const csd::Tracks tracks = hundred(1280, 720);
  csd::OverlayComposition composition;
  for (auto _ : state) {
    GstBuffer *buffer = gst_buffer_new();
    composition.attach(buffer, tracks, 0, 0, 720);
    gst_buffer_unref(buffer);
  }
}

BENCHMARK_CAPTURE(draw, I420, "I420")->Unit(benchmark::kMicrosecond);
BENCHMARK_CAPTURE(draw, NV12, "NV12")->Unit(benchmark::kMicrosecond);
BENCHMARK_CAPTURE(draw, UYVY, "UYVY")->Unit(benchmark::kMicrosecond);
BENCHMARK_CAPTURE(draw, BGRx, "BGRx")->Unit(benchmark::kMicrosecond);
BENCHMARK_CAPTURE(draw, RGBA, "RGBA")->Unit(benchmark::kMicrosecond);
BENCHMARK_CAPTURE(draw, v210, "v210")->Unit(benchmark::kMicrosecond);
BENCHMARK_CAPTURE(draw, I420_10LE, "I420_10LE")->Unit(benchmark::kMicrosecond);
BENCHMARK_CAPTURE(draw, P010_10LE, "P010_10LE")->Unit(benchmark::kMicrosecond);
BENCHMARK(attach)->Unit(benchmark::kMicrosecond);

}  // namespace
