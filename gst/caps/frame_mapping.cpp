// SPDX-License-Identifier: LGPL-2.1-or-later
#include "caps/frame_mapping.h"

#include <algorithm>
#include <stdexcept>

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

#define CSD_VIDEO_FIELDS ", interlace-mode = (string) { progressive, interleaved, mixed }"

GstCaps *template_caps() {
  static constexpr char rest[] = ", width = " GST_VIDEO_SIZE_RANGE ", height = " GST_VIDEO_SIZE_RANGE
                                 ", framerate = " GST_VIDEO_FPS_RANGE CSD_VIDEO_FIELDS;
  static constexpr char composition[] = "(" GST_CAPS_FEATURE_META_GST_VIDEO_OVERLAY_COMPOSITION ")";
  // Features with and without SystemMemory don't intersect, and elements use both spellings.
  static constexpr char system_composition[] =
      "(" GST_CAPS_FEATURE_MEMORY_SYSTEM_MEMORY ", " GST_CAPS_FEATURE_META_GST_VIDEO_OVERLAY_COMPOSITION ")";
  GstCaps *caps = gst_caps_new_empty();
  for (const char *features : {"", composition, system_composition})
    for (const char *formats : {"{ " CSD_USUAL_FORMATS " }", "{ " CSD_OTHER_FORMATS " }"}) {
      gchar *text = g_strconcat("video/x-raw", features, ", format = (string) ", formats, rest, nullptr);
      gst_caps_append(caps, gst_caps_from_string(text));
      g_free(text);
    }
  return caps;
}

GstCaps *any_memory_caps() {
  // The common formats first: a source that supports all would pick one that nothing else accepts.
  GstCaps *caps = template_caps();
  gst_caps_append(caps, gst_caps_from_string("video/x-raw(ANY)" CSD_VIDEO_FIELDS));
  return caps;
}

bool can_map(GstCaps *caps) {
  GstCaps *mappable = template_caps();
  const bool can = gst_caps_can_intersect(caps, mappable);
  gst_caps_unref(mappable);
  return can;
}

bool read_caps(GstCaps *caps, GstVideoInfo &info) {
  if (can_map(caps)) return gst_video_info_from_caps(&info, caps);
  const GstStructure *structure = gst_caps_get_structure(caps, 0);
  int width = 0, height = 0;
  if (!gst_structure_get_int(structure, "width", &width) || !gst_structure_get_int(structure, "height", &height) ||
      width < 1 || height < 1)
    return false;
  gst_video_info_set_format(&info, GST_VIDEO_FORMAT_ENCODED, static_cast<guint>(width), static_cast<guint>(height));
  gst_structure_get_fraction(structure, "framerate", &info.fps_n, &info.fps_d);
  gst_structure_get_fraction(structure, "pixel-aspect-ratio", &info.par_n, &info.par_d);
  return true;
}

GstCaps *complete_caps(GstCaps *caps) {
  GstCaps *complete = gst_caps_copy(caps);
  for (guint i = 0; i < gst_caps_get_size(complete); ++i) {
    GstStructure *structure = gst_caps_get_structure(complete, i);
    if (!gst_structure_has_field(structure, "interlace-mode"))
      gst_structure_set(structure, "interlace-mode", G_TYPE_STRING, "progressive", nullptr);
  }
  return complete;
}

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
  const gint64 width = GST_VIDEO_FORMAT_INFO_SCALE_WIDTH(&format, c, gint64{frame.info.width});
  const SamplePlace place = sample_place(format, c);
  return place.offset + (width - 1) * format.pixel_stride[c] + place.bytes;
}

/// Whether all lines lie in the mapped memory. GStreamer (1.22) takes offsets and strides from the GstVideoMeta but
/// only checks that a plane's first byte is mapped.
static bool holds_its_lines(const GstVideoFrame &frame) {
  for (guint c = 0; c < GST_VIDEO_FRAME_N_COMPONENTS(&frame); ++c) {
    const guint plane = GST_VIDEO_FRAME_COMP_PLANE(&frame, c);
    const GstMapInfo &map = frame.map[plane];
    const gint64 begin = static_cast<const guint8 *>(frame.data[plane]) - map.data;
    const gint64 height = GST_VIDEO_FORMAT_INFO_SCALE_HEIGHT(frame.info.finfo, c, gint64{frame.info.height});
    const gint64 last = begin + (height - 1) * GST_VIDEO_FRAME_PLANE_STRIDE(&frame, plane);
    if (std::min(begin, last) < 0 || std::max(begin, last) + line_bytes(frame, c) > static_cast<gint64>(map.size))
      return false;
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
  if (frame_.meta && !holds_its_lines(frame_)) {
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

const guint8 *plane_end(const GstVideoFrame &frame, guint plane) {
  // With a GstVideoMeta planes are mapped one by one, otherwise all at once (the other maps are then unset).
  const GstMapInfo &map = frame.map[frame.meta ? plane : 0];
  const guint8 *end = map.data + map.size;
  const auto *first = static_cast<const guint8 *>(frame.data[plane]);
  for (guint other = 0; other < GST_VIDEO_FRAME_N_PLANES(&frame); ++other) {
    const auto *start = static_cast<const guint8 *>(frame.data[other]);
    if (start > first && start < end) end = start;
  }
  return end;
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
  const bool host_endian = GST_VIDEO_FORMAT_INFO_FORMAT(&format) == GST_VIDEO_FORMAT_ARGB64;
  return {.offset = offset % 2 == 1 ? 2 * offset : offset,
          .bytes = 2,
          .shift = shift,
          .big_endian = host_endian && G_BYTE_ORDER == G_BIG_ENDIAN};
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

FrameView frame_view(const GstVideoFrame &frame, const GstVideoInfo &caps, const GstVideoCropMeta *crop) {
  const GstVideoFormatInfo &format = *frame.info.finfo;
  const PictureArea area = picture_area(frame, caps, crop);
  const Fields fields = frame_fields(frame);

  FrameView view;
  view.model = GST_VIDEO_FORMAT_INFO_IS_GRAY(&format)  ? ColourModel::gray
               : GST_VIDEO_FORMAT_INFO_IS_RGB(&format) ? ColourModel::rgb
                                                       : ColourModel::yuv;
  set_colour(view, caps);
  view.open_range = GST_VIDEO_FORMAT_INFO_FORMAT(&format) == GST_VIDEO_FORMAT_GRAY16_LE;
  view.width = area.width;
  view.height = view.rows = area.height;
  if (area.width == 0) return view;

  int first_line = area.y;  // in the frame
  int line_step = 1;
  // In a mixed stream the view of a progressive frame is its top field, because the tracker can't change the frame size
  // between frames.
  const bool as_field =
      fields != Fields::progressive || GST_VIDEO_INFO_INTERLACE_MODE(&frame.info) == GST_VIDEO_INTERLACE_MODE_MIXED;
  if (as_field) {
    // A field's lines have its parity in the frame; a crop that starts on an odd line swaps the parities.
    view.row_offset = (area.y & 1) == (fields == Fields::bottom_first ? 1 : 0) ? 0 : 1;
    if (view.row_offset < area.height) {
      view.row_step = line_step = 2;
      // The same count for both parities, for the same reason: with an odd height the last line is dropped.
      view.rows = std::max(area.height / 2, 1);
      first_line += view.row_offset;
    } else {
      view.row_offset = 0;  // a single line, of the other field: better than none
    }
  }

  if (const SampleGroups *groups = sample_groups(format)) {
    view.packing = groups->packing;
    const std::ptrdiff_t stride = GST_VIDEO_FRAME_PLANE_STRIDE(&frame, 0);
    view.x_offset = area.x % groups->pixels;
    view.component[0].data = static_cast<const guint8 *>(GST_VIDEO_FRAME_PLANE_DATA(&frame, 0)) + first_line * stride +
                             area.x / groups->pixels * groups->bytes;
    view.component[0].row_stride = stride * line_step;
    return view;
  }

  const guint colours = view.model == ColourModel::gray ? 1 : 3;  // alpha isn't used
  for (guint c = 0; c < colours; ++c) {
    Component &out = view.component[c];
    out = whole_component(frame, c);
    const std::uint8_t *base = out.data;
    const std::ptrdiff_t stride = out.row_stride;

    int line = first_line >> out.sub_y;
    const bool in_both_fields = line_step == 2 && out.sub_y > 0 && fields == Fields::progressive;
    if (line_step == 2 && out.sub_y > 0 && !in_both_fields) {
      // Interlaced 4:2:0: chroma lines alternate between the fields like luma lines.
      line = ((first_line >> 1) >> out.sub_y) * 2 + (first_line & 1);
    }
    const std::ptrdiff_t column = (area.x >> out.sub_x) * out.pixel_stride;
    out.data = base + line * stride + column;
    out.row_stride = stride * line_step;

    if (in_both_fields) {
      // Progressive 4:2:0: each chroma line belongs to a line of both fields.
      out.row_stride = stride;
      out.sub_y = 0;
    } else if (line_step == 2 && out.sub_y > 0) {
      // With 4n+2 lines the bottom field's last chroma line is one more than the picture needs. GStreamer's default
      // layout has it; a GstVideoMeta's may not: the view then uses the chroma lines of both fields, one per row.
      const int last = line + 2 * ((view.rows - 1) >> out.sub_y);
      const int needed = GST_VIDEO_FRAME_COMP_HEIGHT(&frame, c);
      const guint8 *last_byte =
          base + last * stride + ((area.x + area.width - 1) >> out.sub_x) * out.pixel_stride + out.bytes;
      if (last >= needed && last_byte > plane_end(frame, format.plane[c])) {
        out.data = base + (first_line >> 1) * stride + column;
        out.row_stride = stride;
        out.sub_y = 0;
      }
    }
  }
  return view;
}

}  // namespace csd
