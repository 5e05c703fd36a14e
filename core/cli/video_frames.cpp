// SPDX-License-Identifier: LGPL-2.1-or-later
#include "cli/video_frames.h"

#include <gst/app/gstappsink.h>
#include <gst/gst.h>
#include <gst/video/video.h>

#include <stdexcept>

namespace csd::cli {
namespace {

struct Unref {
  void operator()(gpointer object) const { gst_object_unref(object); }
};
struct UnrefSample {
  void operator()(GstSample *sample) const { gst_sample_unref(sample); }
};

}  // namespace

struct VideoFrames::Pipeline {
  std::unique_ptr<GstElement, Unref> pipeline, sink;
  ~Pipeline() {
    if (pipeline) gst_element_set_state(pipeline.get(), GST_STATE_NULL);
  }

  /// The next frame; null at the end. Throws what the bus tells, if anything went wrong.
  std::unique_ptr<GstSample, UnrefSample> pull(const std::string &file) const {
    const std::unique_ptr<GstBus, Unref> bus(gst_element_get_bus(pipeline.get()));
    for (;;) {
      // A pipeline that fails to start wakes nobody who waits at the sink.
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
}

VideoFrames::~VideoFrames() = default;

void VideoFrames::open() {
  pipeline_ = std::make_unique<Pipeline>();
  GError *error = nullptr;
  pipeline_->pipeline.reset(
      gst_parse_launch("filesrc name=file ! decodebin ! videoconvert ! video/x-raw,format=BGR ! appsink name=sink "
                       "sync=false max-buffers=2",
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

cv::Mat VideoFrames::at(std::uint64_t number) {
  if (next_ == number + 1) return current_;
  if (next_ > number) open();
  while (next_ <= number) {
    const std::unique_ptr<GstSample, UnrefSample> sample = pipeline_->pull(file_);
    if (!sample) return {};
    if (++next_ <= number) continue;
    GstVideoInfo info;
    GstVideoFrame frame;
    if (!gst_video_info_from_caps(&info, gst_sample_get_caps(sample.get())) ||
        !gst_video_frame_map(&frame, &info, gst_sample_get_buffer(sample.get()), GST_MAP_READ))
      throw std::runtime_error(file_ + ": frame " + std::to_string(number) + " can't be mapped");
    current_ = cv::Mat(info.height, info.width, CV_8UC3, GST_VIDEO_FRAME_PLANE_DATA(&frame, 0),
                       static_cast<std::size_t>(GST_VIDEO_FRAME_PLANE_STRIDE(&frame, 0)))
                   .clone();
    gst_video_frame_unmap(&frame);
  }
  return current_;
}

}  // namespace csd::cli
