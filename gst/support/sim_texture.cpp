// SPDX-License-Identifier: LGPL-2.1-or-later
#include "support/sim_texture.h"

#include <gst/base/gsttypefindhelper.h>
#include <gst/video/video.h>

#include <array>
#include <filesystem>
#include <fstream>
#include <memory>
#include <stdexcept>

#include "record/file_name.h"

namespace csd {
namespace {

constexpr int longest_wait = 20;  // seconds

struct Stopped {
  void operator()(GstElement *pipeline) const {
    gst_element_set_state(pipeline, GST_STATE_NULL);
    gst_object_unref(pipeline);
  }
};
template <class T, auto Unref>
struct Unreffed {
  void operator()(T *object) const { Unref(object); }
};
using Pipeline = std::unique_ptr<GstElement, Stopped>;
using Caps = std::unique_ptr<GstCaps, Unreffed<GstCaps, gst_caps_unref>>;
using Element = std::unique_ptr<GstElement, Unreffed<void, gst_object_unref>>;
using Sample = std::unique_ptr<GstSample, Unreffed<GstSample, gst_sample_unref>>;

[[noreturn]] void fail(const std::string &file, const std::string &why) {
  throw std::invalid_argument("texture: " + quoted(file) + " " + why +
                              ". Name a picture that GStreamer can decode, of at most 8192 × 8192 pixels.");
}

/// The pipeline's first error message.
std::string error_of(GstElement *pipeline) {
  std::string text = "can't be decoded";
  GstBus *bus = gst_element_get_bus(pipeline);
  if (GstMessage *message = gst_bus_pop_filtered(bus, GST_MESSAGE_ERROR)) {
    GError *error = nullptr;
    gst_message_parse_error(message, &error, nullptr);
    text = std::string("can't be decoded: ") + error->message;
    g_error_free(error);
    gst_message_unref(message);
  }
  gst_object_unref(bus);
  return text;
}

/// The type of a picture, from the start of its file; none for an unreadable file, which filesrc reports better.
/// Accepts only pictures: decodebin would open whatever a playlist names, even from a network. Throws
/// std::invalid_argument.
Caps type_of(const std::string &file) {
  std::error_code none;
  const auto status = std::filesystem::status(file, none);
  if (!std::filesystem::exists(status)) return nullptr;
  if (!std::filesystem::is_regular_file(status)) fail(file, "is not a file");
  std::ifstream in(file, std::ios::binary);
  std::array<char, 16384> begin;
  in.read(begin.data(), begin.size());
  if (in.gcount() == 0) return nullptr;
  Caps caps(gst_type_find_helper_for_data(nullptr, reinterpret_cast<const guint8 *>(begin.data()),
                                          static_cast<gsize>(in.gcount()), nullptr));
  if (!caps) fail(file, "is not a picture");
  const std::string name = gst_structure_get_name(gst_caps_get_structure(caps.get(), 0));
  if (!name.starts_with("image/")) fail(file, "is not a picture (its type is " + name + ")");
  return caps;
}

}  // namespace

cv::Mat load_picture(const std::string &file) {
  const Caps type = type_of(file);
  // Uses GStreamer: the plugin links no image library of its own.
  GError *error = nullptr;
  Pipeline pipeline(gst_parse_launch(
      // A file of a few bytes may claim to be a picture of gigabytes.
      "filesrc name=file ! decodebin name=decode ! video/x-raw(ANY),width=[1,8192],height=[1,8192] ! videoconvert"
      " ! video/x-raw,format=BGR ! appsink name=sink sync=false",
      &error));
  if (error) {
    const std::string text = error->message;
    g_error_free(error);
    fail(file, "can't be decoded: " + text);
  }
  const Element source(gst_bin_get_by_name(GST_BIN(pipeline.get()), "file"));
  const Element sink(gst_bin_get_by_name(GST_BIN(pipeline.get()), "sink"));
  const Element decode(gst_bin_get_by_name(GST_BIN(pipeline.get()), "decode"));
  g_object_set(source.get(), "location", file.c_str(), nullptr);
  g_object_set(decode.get(), "sink-caps", type.get(), nullptr);
  gst_element_set_state(pipeline.get(), GST_STATE_PAUSED);
  const GstStateChangeReturn prerolled =
      gst_element_get_state(pipeline.get(), nullptr, nullptr, longest_wait * GST_SECOND);
  if (prerolled == GST_STATE_CHANGE_ASYNC) {
    // Leaks a decoder that never returns, like GStreamer 1.22's jpegdec on some files: stopping it would wait for it.
    (void)pipeline.release();
    fail(file,
         "is not decoded after " + std::to_string(longest_wait) + " s; the decoder is left behind, still at work");
  }
  if (prerolled != GST_STATE_CHANGE_SUCCESS) fail(file, error_of(pipeline.get()));
  GstSample *pulled = nullptr;
  g_signal_emit_by_name(sink.get(), "pull-preroll", &pulled);
  const Sample sample(pulled);
  GstVideoInfo info;
  GstVideoFrame frame;
  if (!sample || !gst_video_info_from_caps(&info, gst_sample_get_caps(sample.get())) ||
      !gst_video_frame_map(&frame, &info, gst_sample_get_buffer(sample.get()), GST_MAP_READ)) {
    fail(file, "holds no picture");
  }
  cv::Mat picture = cv::Mat(info.height, info.width, CV_8UC3, GST_VIDEO_FRAME_PLANE_DATA(&frame, 0),
                            static_cast<std::size_t>(GST_VIDEO_FRAME_PLANE_STRIDE(&frame, 0)))
                        .clone();
  gst_video_frame_unmap(&frame);
  return picture;
}

}  // namespace csd
