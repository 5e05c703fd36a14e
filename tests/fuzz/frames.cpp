// SPDX-License-Identifier: LGPL-2.1-or-later
#include <algorithm>
#include <vector>

#include "caps/frame_mapping.h"
#include "elements.h"

namespace csd_fuzz {
namespace {

constexpr gsize max_bytes = 64 << 10;

/// Exactly these bytes, so that a read beyond them is detected. The allocator's own memory is aligned and longer.
GstMemory *memory(const std::vector<guint8> &bytes, gsize from, gsize size, bool read_only) {
  const gsize there = size > planted_bytes() ? size - planted_bytes() : size;
  auto *copy = static_cast<guint8 *>(g_malloc(std::max<gsize>(there, 1)));
  std::copy_n(bytes.begin() + static_cast<std::ptrdiff_t>(from), there, copy);
  return gst_memory_new_wrapped(read_only ? GST_MEMORY_FLAG_READONLY : static_cast<GstMemoryFlags>(0), copy, size, 0,
                                size, copy, g_free);
}

/// Moving squares, with a hash of their place as brightness: most formats have something to track.
std::vector<guint8> pixels(gsize size, gsize stride, unsigned index) {
  std::vector<guint8> bytes(size);
  for (gsize i = 0; i < size; ++i) {
    const auto x = static_cast<guint32>(i % stride + index), y = static_cast<guint32>(i / stride + index / 2);
    guint32 h = (x / 5) * 2654435761u ^ (y / 5) * 40503u;
    h ^= h >> 13;
    bytes[i] = static_cast<guint8>(h * 0x5bd1e995u >> 24);
  }
  return bytes;
}

/// A padded GstVideoMeta as decoders add it, or one with wrong values.
void add_video_meta(Numbers &from, GstBuffer *buffer, const GstVideoInfo &info) {
  gsize offset[GST_VIDEO_MAX_PLANES];
  gint stride[GST_VIDEO_MAX_PLANES];
  std::copy_n(info.offset, GST_VIDEO_MAX_PLANES, offset);
  std::copy_n(info.stride, GST_VIDEO_MAX_PLANES, stride);
  GstVideoMeta *meta = gst_buffer_add_video_meta_full(buffer, GST_VIDEO_FRAME_FLAG_NONE, GST_VIDEO_INFO_FORMAT(&info),
                                                      static_cast<guint>(info.width), static_cast<guint>(info.height),
                                                      GST_VIDEO_INFO_N_PLANES(&info), offset, stride);
  for (unsigned lies = choose(from, 3); lies > 0; --lies) {
    const unsigned plane = choose(from, GST_VIDEO_MAX_PLANES - 1);
    switch (choose(from, 5)) {
      case 0:
        meta->offset[plane] = from.ConsumeIntegralInRange<gsize>(0, max_bytes);
        break;
      case 1:
        meta->stride[plane] = from.ConsumeIntegralInRange<gint>(-4096, 65535);
        break;
      case 2:
        meta->width = from.ConsumeIntegralInRange<guint>(0, 65535);
        break;
      case 3:
        meta->height = from.ConsumeIntegralInRange<guint>(0, 65535);
        break;
      case 4:
        meta->n_planes = choose(from, GST_VIDEO_MAX_PLANES);
        break;
      default:
        // GST_VIDEO_FORMAT_UNKNOWN stands for formats beyond those that GStreamer knows.
        meta->format = static_cast<GstVideoFormat>(choose(from, GST_VIDEO_FORMAT_AV12));
    }
  }
}

GstBuffer *new_frame(Numbers &from, const GstVideoInfo &info, unsigned index, bool wild) {
  gsize size = std::min(info.size, max_bytes);
  const bool odd_size = wild && one_in(from, 4), split = wild && one_in(from, 4), read_only = wild && one_in(from, 4);
  if (odd_size) size = one_in(from, 3) ? from.ConsumeIntegralInRange<gsize>(0, max_bytes) : size - choose(from, 200);
  if (size > max_bytes) size = 0;
  const auto bytes = pixels(size, static_cast<gsize>(std::max(info.stride[0], 1)), index);
  GstBuffer *buffer = gst_buffer_new();
  const gsize first = split ? from.ConsumeIntegralInRange<gsize>(0, size) : size;
  gst_buffer_append_memory(buffer, memory(bytes, 0, first, read_only));
  if (split) gst_buffer_append_memory(buffer, memory(bytes, first, size - first, one_in(from, 2)));
  return buffer;
}

void set_times(Numbers &from, GstBuffer *buffer, unsigned index) {
  GST_BUFFER_PTS(buffer) = index * 40 * GST_MSECOND;
  GST_BUFFER_DURATION(buffer) = 40 * GST_MSECOND;
  if (one_in(from, 8)) GST_BUFFER_PTS(buffer) = from.ConsumeIntegral<guint64>();
  if (one_in(from, 8)) GST_BUFFER_DURATION(buffer) = from.ConsumeIntegral<guint64>();
}

}  // namespace

std::string text(Numbers &from, std::size_t most) {
  std::string text = from.ConsumeRandomLengthString(most);
  return text.substr(0, text.find('\0'));
}

/// A byte means the format that it meant when there were 24 formats. Only those from 190 on mean later ones: no input
/// stored at that time used them.
static const std::string &format_of(unsigned byte) {
  static const std::vector<std::string> formats = [] {
    std::vector<std::string> names;
    gchar **list = g_strsplit_set(
        CSD_NATIVE_FORMATS ", AYUV64, v216, RGB15, UYVP, NV12_10LE32, NV12_64Z32, IYU1, YUV9, RGB8P", "{}, ", -1);
    for (gchar **name = list; *name; ++name)
      if (**name) names.emplace_back(*name);
    g_strfreev(list);
    return names;
  }();
  constexpr std::size_t first = 24, later = 190;
  return formats[byte >= later && byte - later < formats.size() - first ? first + byte - later : byte % first];
}

GstCaps *video_caps(Numbers &from, bool wild) {
  const bool odd = wild && one_in(from, 4);  // what no element, or hardly any, should take
  std::string format = format_of(choose(from, 255));
  int width = static_cast<int>(choose(from, 79)) + 1, height = static_cast<int>(choose(from, 63)) + 1;
  if (odd) {
    if (one_in(from, 2)) format = pick(from, {"AYUV", "P010_10BE", "GRAY16_BE", "NV12_64Z32", "ENCODED", "none"});
    if (one_in(from, 2)) width = from.ConsumeIntegral<int>();
    if (one_in(from, 2)) height = from.ConsumeIntegral<int>();
  }
  GstCaps *caps =
      gst_caps_new_simple(odd && one_in(from, 8) ? "video/x-bayer" : "video/x-raw", "format", G_TYPE_STRING,
                          format.c_str(), "width", G_TYPE_INT, width, "height", G_TYPE_INT, height, "framerate",
                          GST_TYPE_FRACTION, pick(from, {25, 0, 1, 60000}), pick(from, {1, 1001, 2}), nullptr);
  const unsigned more = choose(from, 31);
  if (more & 1)
    gst_caps_set_simple(caps, "interlace-mode", G_TYPE_STRING,
                        pick(from, {"interleaved", "mixed", "progressive", "fields", "alternate", "some"}), nullptr);
  if (more & 2)
    gst_caps_set_simple(caps, "field-order", G_TYPE_STRING, pick(from, {"top-field-first", "bottom-field-first", "no"}),
                        nullptr);
  if (more & 4)
    gst_caps_set_simple(caps, "colorimetry", G_TYPE_STRING, pick(from, {"bt601", "bt709", "1:4:0:0", "2:3:16:4", "?"}),
                        "pixel-aspect-ratio", GST_TYPE_FRACTION, pick(from, {1, 16, G_MAXINT}), pick(from, {1, 15}),
                        nullptr);
  if (more & 8)
    gst_caps_set_features(caps, 0,
                          gst_caps_features_new(pick(from, {GST_CAPS_FEATURE_META_GST_VIDEO_OVERLAY_COMPOSITION,
                                                            GST_CAPS_FEATURE_FORMAT_INTERLACED, "memory:DMABuf"}),
                                                nullptr));
  if (odd && (more & 16))
    gst_structure_remove_field(gst_caps_get_structure(caps, 0), pick(from, {"format", "width", "height", "framerate"}));
  return caps;
}

GstBuffer *frame(Numbers &from, const GstCaps *caps, unsigned index, bool wild) {
  GstVideoInfo info;
  if (!caps || !gst_video_info_from_caps(&info, caps)) {
    gst_video_info_init(&info);
    info.size = choose(from, 255);
  }
  GstBuffer *buffer = new_frame(from, info, index, wild);
  if (wild && one_in(from, 2) && GST_VIDEO_INFO_N_PLANES(&info) > 0) add_video_meta(from, buffer, info);
  if (wild && one_in(from, 4)) {
    GstVideoCropMeta *crop = gst_buffer_add_video_crop_meta(buffer);
    for (guint *field : {&crop->x, &crop->y, &crop->width, &crop->height})
      *field = one_in(from, 4) ? from.ConsumeIntegral<guint>() : choose(from, 80);
  }
  if (wild) {
    const unsigned flags = choose(from, 63);
    if (flags & 1) GST_BUFFER_FLAG_SET(buffer, GST_VIDEO_BUFFER_FLAG_INTERLACED);
    if (flags & 2) GST_BUFFER_FLAG_SET(buffer, GST_VIDEO_BUFFER_FLAG_TFF);
    if (flags & 4) GST_BUFFER_FLAG_SET(buffer, GST_BUFFER_FLAG_DISCONT);
    if (flags & 8) GST_BUFFER_FLAG_SET(buffer, GST_BUFFER_FLAG_GAP);
  }
  set_times(from, buffer, index);
  return buffer;
}

}  // namespace csd_fuzz
