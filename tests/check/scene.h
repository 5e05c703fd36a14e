// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <gst/video/video.h>

#include <array>
#include <cmath>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

/// One scene in every raw format, made by GStreamer's own converter.
namespace scene {

using Rgb = std::array<double, 3>;

/// The same noise in R, G and B, so that luma identifies every pixel, plus smooth colour (R rises by 2 a pixel along x,
/// B along y), so that subsampling costs little. With `fields`, odd lines swap red and blue.
inline Rgb colour(int x, int y, bool fields = false) {
  std::uint32_t h = static_cast<std::uint32_t>(x) * 0x9e3779b1u ^ static_cast<std::uint32_t>(y) * 0x85ebca6bu;
  h ^= h >> 15;
  h *= 0x2c1b3c6du;
  h ^= h >> 13;
  const double noise = 100 + h % 61;
  const auto ramp = [](int t) { return std::abs(t % 60 - 30) * 2.0; };  // 0…60
  const double red = ramp(x), blue = ramp(y / (fields ? 2 : 1));
  if (fields) return y % 2 == 0 ? Rgb{noise + 60, noise, noise - 60} : Rgb{noise - 60, noise, noise + 60};
  return {noise + red, noise, noise + blue};
}

struct Unref {
  void operator()(GstBuffer *buffer) const { gst_buffer_unref(buffer); }
};
using Buffer = std::unique_ptr<GstBuffer, Unref>;

/// A mapped frame; the destructor unmaps it.
struct Frame : GstVideoFrame {
  Frame(const GstVideoInfo &info, GstBuffer *buffer, GstMapFlags flags) : GstVideoFrame{} {
    mapped = gst_video_frame_map(this, &info, buffer, flags);
  }
  Frame(const Frame &) = delete;
  Frame &operator=(const Frame &) = delete;
  ~Frame() {
    if (mapped) gst_video_frame_unmap(this);
  }
  bool mapped = false;
};

/// Formats of CSD_NATIVE_FORMATS by name, in that order.
inline std::vector<GstVideoFormat> formats(const char *list) {
  std::vector<GstVideoFormat> out;
  gchar **names = g_strsplit_set(list, "{}, ", -1);
  for (gchar **name = names; *name; ++name)
    if (**name) out.push_back(gst_video_format_from_string(*name));
  g_strfreev(names);
  return out;
}

inline GstVideoInfo info_of(GstVideoFormat format, int width, int height,
                            GstVideoInterlaceMode mode = GST_VIDEO_INTERLACE_MODE_PROGRESSIVE) {
  GstVideoInfo info;
  gst_video_info_set_interlaced_format(&info, format, mode, static_cast<guint>(width), static_cast<guint>(height));
  return info;
}

/// MT2110T and MT2110R. GStreamer's own functions (seen, 1.26) unpack and pack only tiles that lie within the width.
inline bool takes_whole_tiles_only(const GstVideoFormatInfo &format) {
  const std::string name = GST_VIDEO_FORMAT_INFO_NAME(&format);
  return name == "MT2110T" || name == "MT2110R";
}

/// The pixels to ask these functions for, so that they do all of `width`.
inline int whole_width(const GstVideoFormatInfo &format, int width) {
  return takes_whole_tiles_only(format) ? (width + 15) / 16 * 16 : width;
}

/// Whether GStreamer's own functions keep the fields' chroma apart. In the formats named here they unpack it as that of
/// both fields (seen, 1.22 and 1.26).
inline bool knows_fields(const GstVideoFormatInfo &format) {
  return !takes_whole_tiles_only(format) && GST_VIDEO_FORMAT_INFO_NAME(&format) != std::string("NV12_10BE_8L128");
}

/// A buffer of that format with every byte set to `fill`. With `padding` it has a GstVideoMeta with that many extra
/// pixels and lines on all sides, for unusual strides and offsets.
inline Buffer allocate(const GstVideoInfo &info, unsigned padding = 0, std::uint8_t fill = 0xa5) {
  GstVideoInfo layout = info;
  if (padding > 0 && !GST_VIDEO_FORMAT_INFO_IS_TILED(info.finfo)) {
    GstVideoAlignment align;
    gst_video_alignment_reset(&align);
    align.padding_left = align.padding_right = align.padding_top = align.padding_bottom = padding;
    gst_video_info_align(&layout, &align);
  }
  // Interlaced P010 of 4n+2 lines lacks a chroma line that GStreamer's own packing writes to (seen in 1.22): adds room
  // for it.
  const gsize size = layout.size + static_cast<gsize>(GST_VIDEO_INFO_PLANE_STRIDE(&layout, 0));
  Buffer buffer(gst_buffer_new_allocate(nullptr, size, nullptr));
  gst_buffer_memset(buffer.get(), 0, fill, size);
  if (padding > 0)
    gst_buffer_add_video_meta_full(buffer.get(), GST_VIDEO_FRAME_FLAG_NONE, GST_VIDEO_INFO_FORMAT(&info),
                                   static_cast<guint>(info.width), static_cast<guint>(info.height),
                                   GST_VIDEO_INFO_N_PLANES(&info), layout.offset, layout.stride);
  return buffer;
}

/// Converts one frame into another of the same size.
inline void convert(const GstVideoInfo &from, GstBuffer *source, const GstVideoInfo &to, GstBuffer *destination,
                    GstVideoChromaMode chroma = GST_VIDEO_CHROMA_MODE_FULL) {
  GstVideoConverter *converter = gst_video_converter_new(
      &from, &to,
      gst_structure_new("config", GST_VIDEO_CONVERTER_OPT_DITHER_METHOD, GST_TYPE_VIDEO_DITHER_METHOD,
                        GST_VIDEO_DITHER_NONE, GST_VIDEO_CONVERTER_OPT_CHROMA_MODE, GST_TYPE_VIDEO_CHROMA_MODE, chroma,
                        nullptr));
  Frame in(from, source, GST_MAP_READ), out(to, destination, GST_MAP_WRITE);
  gst_video_converter_frame(converter, &in, &out);
  gst_video_converter_free(converter);
}

/// The scene in that format.
inline Buffer make(const GstVideoInfo &info, unsigned padding = 0, bool fields = false) {
  if (const int whole = whole_width(*info.finfo, info.width); whole > info.width) {
    // The same bytes as a wider picture in the same tiles.
    const GstVideoInfo wide =
        info_of(GST_VIDEO_INFO_FORMAT(&info), whole, info.height, GST_VIDEO_INFO_INTERLACE_MODE(&info));
    const Buffer source = make(wide, 0, fields);
    Buffer out = allocate(info, padding);
    GST_BUFFER_FLAGS(out.get()) = GST_BUFFER_FLAGS(source.get());
    GstMapInfo map;
    gst_buffer_map(source.get(), &map, GST_MAP_READ);
    gst_buffer_fill(out.get(), 0, map.data, map.size);
    gst_buffer_unmap(source.get(), &map);
    return out;
  }
  GstVideoInfo rgb = info_of(GST_VIDEO_FORMAT_xRGB, info.width, info.height, GST_VIDEO_INFO_INTERLACE_MODE(&info));
  Buffer source = allocate(rgb);
  {
    Frame frame(rgb, source.get(), GST_MAP_WRITE);
    auto *line = static_cast<std::uint8_t *>(GST_VIDEO_FRAME_PLANE_DATA(&frame, 0));
    for (int y = 0; y < info.height; ++y, line += GST_VIDEO_FRAME_PLANE_STRIDE(&frame, 0))
      for (int x = 0; x < info.width; ++x) {
        const Rgb c = colour(x, y, fields);
        for (std::size_t k = 0; k < 3; ++k) line[4 * x + 1 + static_cast<int>(k)] = static_cast<std::uint8_t>(c[k]);
      }
  }
  Buffer out = allocate(info, padding);
  if (GST_VIDEO_INFO_INTERLACE_MODE(&info) == GST_VIDEO_INTERLACE_MODE_MIXED) {
    GST_BUFFER_FLAG_SET(source.get(), GST_VIDEO_BUFFER_FLAG_INTERLACED);
    GST_BUFFER_FLAG_SET(out.get(), GST_VIDEO_BUFFER_FLAG_INTERLACED);
  }
  convert(rgb, source.get(), info, out.get());
  return out;
}

}  // namespace scene
