// SPDX-License-Identifier: LGPL-2.1-or-later
#include "programs/video_frames.h"

#include <gst/app/gstappsink.h>
#include <gst/gst.h>
#include <gst/video/video.h>

#include <stdexcept>
#include <vector>

#include "image/colour_rows.h"

namespace csd::programs {
namespace {

struct Unref {
  void operator()(gpointer object) const { gst_object_unref(object); }
};
struct UnrefSample {
  void operator()(GstSample *sample) const { gst_sample_unref(sample); }
};

std::int64_t nanoseconds(GstClockTime time) {
  return GST_CLOCK_TIME_IS_VALID(time) ? static_cast<std::int64_t>(time) : -1;
}

/// Copies a mapped frame, BGR or Y444, to BGR.
cv::Mat to_bgr(const GstVideoFrame &frame) {
  const GstVideoInfo &info = frame.info;
  const auto row = [&frame](guint plane, int y) {
    return static_cast<std::uint8_t *>(GST_VIDEO_FRAME_PLANE_DATA(&frame, plane)) +
           std::ptrdiff_t{y} * GST_VIDEO_FRAME_PLANE_STRIDE(&frame, plane);
  };
  if (GST_VIDEO_INFO_IS_RGB(&info))
    return cv::Mat(info.height, info.width, CV_8UC3, row(0, 0),
                   static_cast<std::size_t>(GST_VIDEO_FRAME_PLANE_STRIDE(&frame, 0)))
        .clone();
  double kr = 0, kb = 0;
  gst_video_color_matrix_get_Kr_Kb(info.colorimetry.matrix, &kr, &kb);
  const auto yuv = YuvCoefficients::make(kr, kb, info.colorimetry.range == GST_VIDEO_COLOR_RANGE_0_255);
  const auto width = static_cast<std::size_t>(info.width);
  std::vector<std::uint8_t> r(width), g(width), b(width);
  cv::Mat bgr(info.height, info.width, CV_8UC3);
  for (int y = 0; y < info.height; ++y) {
    yuv_to_rgb(yuv, row(0, y), row(1, y), row(2, y), info.width, r.data(), g.data(), b.data());
    interleave(b.data(), g.data(), r.data(), info.width, bgr.ptr(y));
  }
  return bgr;
}

}  // namespace

struct VideoFrames::Pipeline {
  std::unique_ptr<GstElement, Unref> pipeline, sink;
  ~Pipeline() {
    if (pipeline) gst_element_set_state(pipeline.get(), GST_STATE_NULL);
  }

  /// The next frame; null at the end. Throws the error on the bus, if any.
  std::unique_ptr<GstSample, UnrefSample> pull(const std::string &file) const {
    const std::unique_ptr<GstBus, Unref> bus(gst_element_get_bus(pipeline.get()));
    for (;;) {
      // A pipeline that fails to start doesn't wake a thread that waits at the sink.
      GstSample *const sample = gst_app_sink_try_pull_sample(GST_APP_SINK(sink.get()), GST_SECOND / 10);
      if (sample) return std::unique_ptr<GstSample, UnrefSample>(sample);
      if (GstMessage *const message = gst_bus_pop_filtered(bus.get(), GST_MESSAGE_ERROR)) {
        GError *error = nullptr;
        gst_message_parse_error(message, &error, nullptr);
        const std::string text = file + ": " + error->message;
        g_error_free(error);
        gst_message_unref(message);
        throw std::runtime_error(text);
      }
      if (gst_app_sink_is_eos(GST_APP_SINK(sink.get()))) return nullptr;
    }
  }
};

VideoFrames::VideoFrames(std::string file) : file_(std::move(file)) {
  gst_init(nullptr, nullptr);
  open();
  at(0);  // reports errors with the first frame
}

VideoFrames::~VideoFrames() = default;

void VideoFrames::open() {
  pipeline_ = std::make_unique<Pipeline>();
  GError *error = nullptr;
  pipeline_->pipeline.reset(
      // videoconvert's conversion to 8-bit BGR is too dark by up to 4 (1.22), so YUV isn't converted here.
      gst_parse_launch("filesrc name=file ! decodebin ! videoconvert ! video/x-raw,format={Y444,BGR} ! appsink "
                       "name=sink sync=false max-buffers=2",
                       &error));
  if (error) {
    const std::string text = error->message;
    g_error_free(error);
    throw std::runtime_error(text);
  }
  const std::unique_ptr<GstElement, Unref> source(gst_bin_get_by_name(GST_BIN(pipeline_->pipeline.get()), "file"));
  pipeline_->sink.reset(gst_bin_get_by_name(GST_BIN(pipeline_->pipeline.get()), "sink"));
  g_object_set(source.get(), "location", file_.c_str(), nullptr);
  gst_element_set_state(pipeline_->pipeline.get(), GST_STATE_PLAYING);
  next_ = 0;
}

Picture VideoFrames::at(std::uint64_t number) {
  if (next_ == number + 1) return current_;
  if (next_ > number) open();
  while (next_ <= number) {
    const std::unique_ptr<GstSample, UnrefSample> sample = pipeline_->pull(file_);
    if (!sample) return {};
    if (++next_ <= number) continue;
    GstBuffer *const buffer = gst_sample_get_buffer(sample.get());
    GstVideoInfo info;
    GstVideoFrame frame;
    if (!gst_video_info_from_caps(&info, gst_sample_get_caps(sample.get())) ||
        !gst_video_frame_map(&frame, &info, buffer, GST_MAP_READ))
      throw std::runtime_error(file_ + ": frame " + std::to_string(number) + " can't be mapped");
    current_.bgr = to_bgr(frame);
    const GstClockTime pts = GST_BUFFER_PTS(buffer);
    current_.pts = nanoseconds(pts);
    current_.duration = nanoseconds(GST_BUFFER_DURATION(buffer));
    const GstSegment *const segment = gst_sample_get_segment(sample.get());
    current_.running_time = nanoseconds(gst_segment_to_running_time(segment, GST_FORMAT_TIME, pts));
    current_.stream_time = nanoseconds(gst_segment_to_stream_time(segment, GST_FORMAT_TIME, pts));
    gst_video_frame_unmap(&frame);
  }
  return current_;
}

}  // namespace csd::programs
