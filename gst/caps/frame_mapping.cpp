// SPDX-License-Identifier: LGPL-2.1-or-later
#include "caps/frame_mapping.h"

#include <algorithm>
#include <stdexcept>

#include "caps/row_unpacker.h"

namespace csd {

namespace {

void set_colour(FrameView &view, const GstVideoInfo &info) {
  GstVideoColorimetry colour = info.colorimetry;
  if (view.model != ColourModel::yuv || colour.matrix == GST_VIDEO_COLOR_MATRIX_UNKNOWN) {
    // GStreamer's default colorimetry for a Y'CbCr picture of this height. Also for RGB, so its luma has the same
    // weights as after a converter.
    GstVideoInfo usual;
    gst_video_info_set_format(&usual, GST_VIDEO_FORMAT_I420, info.width, info.height);
    colour.matrix = usual.colorimetry.matrix;
    if (view.model == ColourModel::yuv && colour.range == GST_VIDEO_COLOR_RANGE_UNKNOWN)
      colour.range = usual.colorimetry.range;
  }
  gst_video_color_matrix_get_Kr_Kb(colour.matrix, &view.kr, &view.kb);
  view.full_range = colour.range == GST_VIDEO_COLOR_RANGE_0_255;
}

}  // namespace

/// gst_video_frame_map() would treat this as a programming error.
static bool contradicts(const GstVideoMeta &meta, const GstVideoInfo &info) {
  return meta.format != GST_VIDEO_INFO_FORMAT(&info) || meta.n_planes != GST_VIDEO_INFO_N_PLANES(&info) ||
         meta.width < static_cast<guint>(info.width) || meta.height < static_cast<guint>(info.height) ||
         meta.width > G_MAXINT || meta.height > G_MAXINT;
}

/// Bytes in a line of a component, from the plane's first byte.
static gint64 line_bytes(const GstVideoFrame &frame, guint c) {
  const GstVideoFormatInfo &format = *frame.info.finfo;
  if (const SampleGroups *groups = sample_groups(format))
    return (gint64{frame.info.width} + groups->pixels - 1) / groups->pixels * groups->bytes;
  if (!is_native(format.format)) {
    const gint64 bytes = plane_line_bytes(format, format.plane[c], frame.info.width);
    return format.pixel_stride[c] > 0 ? bytes : std::max<gint64>(bytes - 3, 1);  // without padding
  }
  const gint64 width = GST_VIDEO_FORMAT_INFO_SCALE_WIDTH(&format, c, gint64{frame.info.width});
  const SamplePlace place = sample_place(format, c);
  return place.offset + (width - 1) * format.pixel_stride[c] + place.bytes;
}

namespace {

/// Addresses, as numbers: what a wrong GstVideoMeta gives may be no pointers.
struct Extent {
  gint64 begin, end;
};

/// Of lines `first` to `last` of a component. They may go upwards in memory or downwards.
Extent lines_extent(const GstVideoFrame &frame, guint c, gint64 first, gint64 last) {
  const guint plane = GST_VIDEO_FRAME_COMP_PLANE(&frame, c);
  const auto at = static_cast<gint64>(reinterpret_cast<guintptr>(frame.data[plane]));
  const gint64 stride = GST_VIDEO_FRAME_PLANE_STRIDE(&frame, plane);
  return {at + std::min(first * stride, last * stride),
          at + std::max(first * stride, last * stride) + line_bytes(frame, c)};
}

bool is_mapped(const GstVideoFrame &frame, guint c, const Extent &extent) {
  const GstMapInfo &map = frame.map[frame.meta ? GST_VIDEO_FRAME_COMP_PLANE(&frame, c) : 0];
  const auto begin = static_cast<gint64>(reinterpret_cast<guintptr>(map.data));
  return extent.begin >= begin && extent.end <= begin + static_cast<gint64>(map.size);
}

}  // namespace

/// Whether all lines lie in the mapped memory. GStreamer (1.22) takes offsets and strides from the GstVideoMeta but
/// only checks that a plane's first byte is mapped.
static bool holds_its_lines(const GstVideoFrame &frame) {
  const GstVideoFormatInfo &format = *frame.info.finfo;
  if (GST_VIDEO_FORMAT_INFO_IS_TILED(&format)) return holds_its_tiles(frame);
  for (guint c = 0; c < GST_VIDEO_FRAME_N_COMPONENTS(&frame); ++c) {
    const bool palette = is_palette(format, GST_VIDEO_FRAME_COMP_PLANE(&frame, c));
    Extent extent = lines_extent(frame, c, 0, palette ? 0 : GST_VIDEO_FRAME_COMP_HEIGHT(&frame, c) - 1);
    if (palette) extent.end = extent.begin + palette_bytes;
    if (!is_mapped(frame, c, extent)) return false;
  }
  return true;
}

MappedFrame::MappedFrame(const GstVideoInfo &info, GstBuffer *buffer, GstMapFlags access) {
  const GstVideoMeta *meta = gst_buffer_get_video_meta(buffer);
  if (meta && contradicts(*meta, info))
    throw std::runtime_error("a frame's pixels can't be mapped: its GstVideoMeta is of another picture than its caps");
  // NO_REF: an extra reference would make the buffer read-only.
  const auto flags = static_cast<GstMapFlags>(access | static_cast<int>(GST_VIDEO_FRAME_MAP_FLAG_NO_REF));
  if (!gst_video_frame_map(&frame_, &info, buffer, flags))
    throw std::runtime_error("a frame's pixels can't be mapped: it is damaged, or smaller than its caps say");
  bool holds = false;
  try {
    // GStreamer's own layout needs no check where we read it in place.
    holds = (!frame_.meta && is_native(GST_VIDEO_INFO_FORMAT(&info))) || holds_its_lines(frame_);
  } catch (const std::runtime_error &) {
  }
  if (!holds) {
    gst_video_frame_unmap(&frame_);
    throw std::runtime_error("a frame's pixels can't be mapped: its GstVideoMeta tells of lines that it doesn't hold");
  }
}

MappedBytes::MappedBytes(GstBuffer *buffer) : buffer_(buffer) {
  if (!gst_buffer_map(buffer, &map_, GST_MAP_READ)) throw std::runtime_error("a buffer can't be mapped");
}

bool views_take_turns(const GstVideoInfo &caps) {
  const GstVideoMultiviewMode mode = GST_VIDEO_INFO_MULTIVIEW_MODE(&caps);
  return mode == GST_VIDEO_MULTIVIEW_MODE_FRAME_BY_FRAME || mode == GST_VIDEO_MULTIVIEW_MODE_MULTIVIEW_FRAME_BY_FRAME;
}

bool is_empty_gap(GstBuffer *buffer) {
  return GST_BUFFER_FLAG_IS_SET(buffer, GST_BUFFER_FLAG_GAP) && gst_buffer_get_size(buffer) == 0;
}

/// For a frame of width×height pixels.
static PictureArea area_of(int width, int height, const GstVideoInfo &caps, const GstVideoCropMeta *crop) {
  if (!crop) {
    // A GstVideoMeta may exceed the caps' size (decoder padding); converters and sinks show the caps' size.
    return {0, 0, std::min(width, GST_VIDEO_INFO_WIDTH(&caps)), std::min(height, GST_VIDEO_INFO_HEIGHT(&caps))};
  }
  const auto clamp = [](guint from, guint length, int limit, int &at, int &size) {
    at = static_cast<int>(std::min<gint64>(from, limit));
    size = static_cast<int>(std::min<gint64>(gint64{from} + length, limit)) - at;
  };
  PictureArea area;
  clamp(crop->x, crop->width, width, area.x, area.width);
  clamp(crop->y, crop->height, height, area.y, area.height);
  if (area.width == 0 || area.height == 0) area.width = area.height = 0;
  return area;
}

PictureArea picture_area(const GstVideoFrame &frame, const GstVideoInfo &caps, const GstVideoCropMeta *crop) {
  return area_of(GST_VIDEO_FRAME_WIDTH(&frame), GST_VIDEO_FRAME_HEIGHT(&frame), caps, crop);
}

PictureArea picture_area(GstBuffer *buffer, const GstVideoInfo &caps) {
  const GstVideoMeta *meta = gst_buffer_get_video_meta(buffer);
  const int width = meta ? static_cast<int>(meta->width) : GST_VIDEO_INFO_WIDTH(&caps);
  const int height = meta ? static_cast<int>(meta->height) : GST_VIDEO_INFO_HEIGHT(&caps);
  return area_of(width, height, caps, gst_buffer_get_video_crop_meta(buffer));
}

Fields frame_fields(const GstVideoFrame &frame) {
  const GstVideoInterlaceMode mode = GST_VIDEO_INFO_INTERLACE_MODE(&frame.info);
  const bool flagged = GST_BUFFER_FLAG_IS_SET(frame.buffer, GST_VIDEO_BUFFER_FLAG_INTERLACED);
  bool top_first = GST_BUFFER_FLAG_IS_SET(frame.buffer, GST_VIDEO_BUFFER_FLAG_TFF);
  if (mode == GST_VIDEO_INTERLACE_MODE_INTERLEAVED) {
    const GstVideoFieldOrder order = GST_VIDEO_INFO_FIELD_ORDER(&frame.info);
    if (order != GST_VIDEO_FIELD_ORDER_UNKNOWN) top_first = order == GST_VIDEO_FIELD_ORDER_TOP_FIELD_FIRST;
  } else if (mode != GST_VIDEO_INTERLACE_MODE_MIXED || !flagged) {
    return Fields::progressive;  // mixed: only the buffer's flags tell, frame by frame
  }
  return top_first ? Fields::top_first : Fields::bottom_first;
}

bool has_line(const GstVideoFrame &frame, guint c, int line) {
  if (line < GST_VIDEO_FRAME_COMP_HEIGHT(&frame, c)) return true;
  const Extent its = lines_extent(frame, c, line, line);
  if (!is_mapped(frame, c, its)) return false;
  for (guint other = 0; other < GST_VIDEO_FRAME_N_COMPONENTS(&frame); ++other) {
    const Extent its_lines = lines_extent(frame, other, 0, GST_VIDEO_FRAME_COMP_HEIGHT(&frame, other) - 1);
    if (GST_VIDEO_FRAME_COMP_PLANE(&frame, other) != GST_VIDEO_FRAME_COMP_PLANE(&frame, c) &&
        its.begin < its_lines.end && its_lines.begin < its.end)
      return false;
  }
  return true;
}

SamplePlace sample_place(const GstVideoFormatInfo &format, guint c) {
  // For these formats GstVideoFormatInfo has only pixel strides and depths (seen, 1.22).
  static constexpr int y210[] = {0, 2, 6};                                   // bytes of Y0 U Y1 V
  static constexpr int y410[] = {10, 0, 20, 30}, bgr10[] = {20, 10, 0, 30};  // lowest bits
  switch (GST_VIDEO_FORMAT_INFO_FORMAT(&format)) {
    case GST_VIDEO_FORMAT_Y210:
      return {.offset = y210[c], .bytes = 2, .shift = 6};
    case GST_VIDEO_FORMAT_Y410:
      return {.bytes = 4, .shift = y410[c]};
    case GST_VIDEO_FORMAT_BGR10A2_LE:
      return {.bytes = 4, .shift = bgr10[c]};
    case GST_VIDEO_FORMAT_r210:
      return {.bytes = 4, .shift = bgr10[c], .big_endian = true};
    default:
      break;
  }
  const int offset = format.poffset[c], shift = static_cast<int>(format.shift[c]);
  if (format.depth[c] <= 8) return {.offset = offset, .shift = shift};
  // GStreamer declares V of P010 and P012 at byte 1 (seen, 1.22). A 16-bit word can't start there: it is word 1.
  return {.offset = offset % 2 == 1 ? 2 * offset : offset,
          .bytes = 2,
          .shift = shift,
          .big_endian = !GST_VIDEO_FORMAT_INFO_IS_LE(&format)};
}

const SampleGroups *sample_groups(const GstVideoFormatInfo &format) {
  static constexpr SampleGroups v210{Packing::v210, 6, 16}, gray10{Packing::gray10, 3, 4};
  switch (GST_VIDEO_FORMAT_INFO_FORMAT(&format)) {
    case GST_VIDEO_FORMAT_v210:
      return &v210;
    case GST_VIDEO_FORMAT_GRAY10_LE32:
      return &gray10;
    default:
      return nullptr;
  }
}

/// Component `c` of a frame from its plane's first byte. For 32-bit words it selects the 16 bits that hold the sample.
static Component whole_component(const GstVideoFrame &frame, guint c) {
  const GstVideoFormatInfo &format = *frame.info.finfo;
  const SamplePlace place = sample_place(format, c);
  const bool wide = place.bytes == 4;
  const int depth = static_cast<int>(format.depth[c]), byte = place.shift / 8;
  const int offset = !wide ? place.offset : place.big_endian ? 2 - byte : byte;
  Component out;
  out.data = static_cast<const guint8 *>(GST_VIDEO_FRAME_PLANE_DATA(&frame, format.plane[c])) + offset;
  out.row_stride = GST_VIDEO_FRAME_PLANE_STRIDE(&frame, format.plane[c]);
  out.pixel_stride = format.pixel_stride[c];
  out.bytes = place.bytes > 1 ? 2 : 1;
  out.shift = static_cast<std::uint8_t>(wide ? 8 : place.shift + depth - 8);
  out.sub_x = static_cast<std::uint8_t>(format.w_sub[c]);
  out.sub_y = static_cast<std::uint8_t>(format.h_sub[c]);
  out.left = static_cast<std::uint8_t>(wide ? 16 - depth - place.shift % 8 : 0);
  out.big_endian = place.big_endian;
  return out;
}

namespace {

/// The lines of the picture, or of its field.
struct Rows {
  int first_line = 0, line_step = 1;  // in the frame
  bool progressive = true;            // the frame, even if the view is a field
};

ComponentLines component_lines(const GstVideoFrame &frame, guint c, const Rows &rows, int count) {
  const GstVideoFormatInfo &format = *frame.info.finfo;
  const int sub_y = static_cast<int>(format.h_sub[c]);
  if (rows.line_step == 1 || sub_y == 0) return {rows.first_line >> sub_y, rows.line_step, sub_y};
  // Progressive 4:2:0: each chroma line belongs to a line of both fields.
  const ComponentLines of_both{rows.first_line >> sub_y, 1, sub_y - 1};
  if (rows.progressive) return of_both;
  // Interlaced 4:2:0: chroma lines alternate between the fields like luma lines.
  const ComponentLines lines{((rows.first_line >> 1) >> sub_y) * 2 + (rows.first_line & 1), 2, sub_y};
  if (GST_VIDEO_FORMAT_INFO_IS_TILED(&format)) return lines;
  // Where the bottom field's last chroma line is missing, the view uses the chroma lines of both fields.
  return has_line(frame, c, lines.first + 2 * ((count - 1) >> sub_y)) ? lines : of_both;
}

/// Makes `view` the first field of an interlaced frame. Returns its lines in the frame.
Rows take_rows(const GstVideoFrame &frame, const PictureArea &area, FrameView &view) {
  const Fields fields = frame_fields(frame);
  Rows rows{area.y, 1, fields == Fields::progressive};
  // In a mixed stream the view of a progressive frame is its top field, because the tracker can't change the frame size
  // between frames.
  const bool as_field =
      fields != Fields::progressive || GST_VIDEO_INFO_INTERLACE_MODE(&frame.info) == GST_VIDEO_INTERLACE_MODE_MIXED;
  if (!as_field) return rows;
  // A field's lines have its parity in the frame; a crop that starts on an odd line swaps the parities.
  view.row_offset = (area.y & 1) == (fields == Fields::bottom_first ? 1 : 0) ? 0 : 1;
  if (view.row_offset < area.height) {
    view.row_step = rows.line_step = 2;
    // The same count for both parities, for the same reason: with an odd height the last line is dropped.
    view.rows = std::max(area.height / 2, 1);
    rows.first_line += view.row_offset;
  } else {
    view.row_offset = 0;  // a single line, of the other field: better than none
  }
  return rows;
}

/// For samples that are packed in groups: the place of the picture's first group.
void set_groups(const GstVideoFrame &frame, const PictureArea &area, const Rows &rows, const SampleGroups &groups,
                FrameView &view) {
  view.packing = groups.packing;
  const std::ptrdiff_t stride = GST_VIDEO_FRAME_PLANE_STRIDE(&frame, 0);
  view.x_offset = area.x % groups.pixels;
  view.component[0].data = static_cast<const guint8 *>(GST_VIDEO_FRAME_PLANE_DATA(&frame, 0)) +
                           rows.first_line * stride + area.x / groups.pixels * groups.bytes;
  view.component[0].row_stride = stride * rows.line_step;
}

FrameView make_view(const GstVideoFrame &frame, const GstVideoInfo &caps, const GstVideoCropMeta *crop, bool native) {
  const GstVideoFormatInfo &format = *frame.info.finfo;
  const PictureArea area = picture_area(frame, caps, crop);

  FrameView view;
  view.model = GST_VIDEO_FORMAT_INFO_IS_GRAY(&format)  ? ColourModel::gray
               : GST_VIDEO_FORMAT_INFO_IS_RGB(&format) ? ColourModel::rgb
                                                       : ColourModel::yuv;
  set_colour(view, caps);
  view.open_range = native && view.model == ColourModel::gray && format.depth[0] == 16;
  view.width = area.width;
  view.height = view.rows = area.height;
  if (area.width == 0) return view;

  const Rows rows = take_rows(frame, area, view);
  if (const SampleGroups *groups = native ? sample_groups(format) : nullptr) {
    set_groups(frame, area, rows, *groups, view);
    return view;
  }

  std::array<ComponentLines, GST_VIDEO_MAX_COMPONENTS> lines;
  for (guint c = 0; c < GST_VIDEO_FRAME_N_COMPONENTS(&frame); ++c)
    if (!is_palette(format, format.plane[c])) lines[c] = component_lines(frame, c, rows, view.rows);
  const guint colours = view.model == ColourModel::gray ? 1 : 3;  // alpha isn't used
  for (guint c = 0; c < colours; ++c) {
    Component &out = view.component[c];
    if (native) {
      out = whole_component(frame, c);
      out.data += lines[c].first * out.row_stride + (area.x >> out.sub_x) * out.pixel_stride;
      out.row_stride *= lines[c].step;
    } else {
      out.sub_x = static_cast<std::uint8_t>(format.w_sub[c]);
    }
    out.sub_y = static_cast<std::uint8_t>(lines[c].sub_y);
  }
  if (!native)
    view.reader = std::make_shared<RowUnpacker>(frame, area.x, area.width, view.rows,
                                                !rows.progressive && rows.line_step == 2, lines, view.component);
  return view;
}

}  // namespace

FrameView frame_view(const GstVideoFrame &frame, const GstVideoInfo &caps, const GstVideoCropMeta *crop) {
  return make_view(frame, caps, crop, is_native(GST_VIDEO_FRAME_FORMAT(&frame)));
}

FrameView unpacked_view(const GstVideoFrame &frame, const GstVideoInfo &caps, const GstVideoCropMeta *crop) {
  return make_view(frame, caps, crop, false);
}

}  // namespace csd
