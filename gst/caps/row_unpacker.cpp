// SPDX-License-Identifier: LGPL-2.1-or-later
#include "caps/row_unpacker.h"

#include <algorithm>
#include <cstring>
#include <stdexcept>

#include "image/samples.h"

namespace csd {

namespace {

/// GStreamer's own functions read past a line's end in some formats (1.22: UYVP and NV12_10LE32 of some widths), by
/// less than this.
constexpr gint64 beyond = 64;

/// Unpack functions write whole groups of pixels.
constexpr int slack = 16;

/// Pixels that are unpacked at once, where the format allows to start within a line.
constexpr int block = 512;

bool has_strides(const GstVideoFormatInfo &format) {
  for (guint c = 0; c < format.n_components; ++c)
    if (!is_palette(format, format.plane[c]) && format.pixel_stride[c] <= 0) return false;
  return true;
}

GstVideoInfo layout_of(const GstVideoFormatInfo &format, gint64 width, int height) {
  GstVideoInfo info;
  if (width > G_MAXINT ||
      !gst_video_info_set_format(&info, format.format, static_cast<guint>(width), static_cast<guint>(height)))
    throw std::runtime_error("a frame's pixels can't be mapped: its lines are too long");
  return info;
}

/// Pixels that fill whole groups of all formats without pixel strides, and whole words of 32 bits.
constexpr int group = 48;

/// The bytes of so many pixels in a line of the plane; 0 if they are no fixed number.
int group_bytes(const GstVideoFormatInfo &format, guint plane) {
  const auto bytes = [&](int groups) {
    const GstVideoInfo info = layout_of(format, gint64{groups} * group, 16);
    return static_cast<int>(GST_VIDEO_INFO_PLANE_STRIDE(&info, plane));
  };
  const int one = bytes(1);
  return bytes(2) == 2 * one && bytes(7) == 7 * one && bytes(30) == 30 * one ? one : 0;
}

/// Unpacking may start at multiples of this column; 0: only at a line's start. The functions' own argument x can't be
/// relied on: in 1.22 it is wrong for v210, UYVP, IYU1, for BGRA64_LE and its kin, and in tiles but for a tile's start.
int unpack_grain(const GstVideoFormatInfo &format) {
  if (GST_VIDEO_FORMAT_INFO_IS_TILED(&format)) {
    const int width = static_cast<int>(GST_VIDEO_FORMAT_INFO_TILE_WIDTH(&format, 0));
    return has_strides(format) && width <= block / 4 ? width : 0;
  }
  if (has_strides(format)) return 4;
  for (guint plane = 0; plane < format.n_planes; ++plane)
    if (group_bytes(format, plane) == 0) return 0;
  return group;
}

guint component_of(const GstVideoFormatInfo &format, guint plane) {
  guint c = 0;
  while (c + 1 < format.n_components && format.plane[c] != plane) ++c;
  return c;
}

}  // namespace

bool unpacks_deep(const GstVideoFormatInfo &format) {
  return gst_video_format_get_info(format.unpack_format)->bits == 16;
}

gint64 plane_line_bytes(const GstVideoFormatInfo &format, guint plane, gint64 width) {
  if (!has_strides(format)) {
    const GstVideoInfo info = layout_of(format, width, 16);
    return GST_VIDEO_INFO_PLANE_STRIDE(&info, plane);
  }
  gint64 bytes = 0;
  for (guint c = 0; c < format.n_components; ++c)
    if (format.plane[c] == plane) {
      const gint64 samples = GST_VIDEO_FORMAT_INFO_SCALE_WIDTH(&format, c, width);
      bytes = std::max(bytes, samples * format.pixel_stride[c]);
    }
  return bytes;
}

bool holds_its_tiles(const GstVideoFrame &frame) {
  const GstVideoFormatInfo &format = *frame.info.finfo;
  const GstVideoInfo usual = layout_of(format, frame.info.width, frame.info.height);
  for (guint plane = 0; plane < GST_VIDEO_FRAME_N_PLANES(&frame); ++plane) {
    const gint stride = GST_VIDEO_FRAME_PLANE_STRIDE(&frame, plane),
               needed = GST_VIDEO_INFO_PLANE_STRIDE(&usual, plane);
    if (stride < 0 || GST_VIDEO_TILE_X_TILES(stride) < GST_VIDEO_TILE_X_TILES(needed) ||
        GST_VIDEO_TILE_Y_TILES(stride) < GST_VIDEO_TILE_Y_TILES(needed))
      return false;
    const gint64 across = GST_VIDEO_TILE_X_TILES(stride), down = GST_VIDEO_TILE_Y_TILES(stride);
    gint64 tiles = across * down;
    const auto mode = GST_VIDEO_FORMAT_INFO_TILE_MODE(&format);
    // With an odd number of columns the zigzag leaves the rectangle.
    if (GST_VIDEO_TILE_MODE_IS_INDEXED(mode))
      for (int y = 0; y < static_cast<int>(GST_VIDEO_TILE_Y_TILES(needed)); ++y)
        for (int x = 0; x < static_cast<int>(GST_VIDEO_TILE_X_TILES(needed)); ++x)
          tiles = std::max<gint64>(
              tiles,
              gint64{gst_video_tile_get_index(mode, x, y, static_cast<gint>(across), static_cast<gint>(down))} + 1);
    // An odd width has a last pair of chroma samples that may lie in a tile more (1.22: NV12_10BE_8L128).
    if (const gint64 bytes = GST_VIDEO_FORMAT_INFO_TILE_STRIDE(&format, plane); bytes > 0) {
      const gint64 bits = gint64{GST_ROUND_UP_2(frame.info.width)} * static_cast<gint64>(format.depth[0]);
      tiles += std::max<gint64>(0, (bits + 8 * bytes - 1) / (8 * bytes) - across);
    }
    const GstMapInfo &map = frame.map[frame.meta ? plane : 0];
    const gint64 begin = static_cast<const guint8 *>(frame.data[plane]) - map.data;
    const gint64 size = GST_VIDEO_FORMAT_INFO_TILE_SIZE(&format, plane);
    if (begin < 0 || begin + tiles * size > static_cast<gint64>(map.size)) return false;
  }
  return true;
}

int whole_groups(const GstVideoFormatInfo &format, int pixels) {
  // In 1.22 the last pixel of an odd number has U for V and V for U in VYUY.
  if (!GST_VIDEO_FORMAT_INFO_IS_TILED(&format)) return (pixels + 3) / 4 * 4;
  // In 1.26 those of MT2110T and MT2110R leave out a tile that isn't whole. The memory holds it: holds_its_tiles().
  const int tile = static_cast<int>(GST_VIDEO_FORMAT_INFO_TILE_WIDTH(&format, 0));
  return tile > 0 ? (pixels + tile - 1) / tile * tile : pixels;
}

MappedLines::MappedLines(const GstVideoFrame &frame, int width)
    : frame_(frame),
      tiled_(GST_VIDEO_FORMAT_INFO_IS_TILED(frame.info.finfo)),
      planes_(static_cast<int>(GST_VIDEO_FRAME_N_PLANES(&frame))) {
  if (tiled_) return;
  const GstVideoFormatInfo &format = *frame.info.finfo;
  const GstVideoInfo wide = layout_of(format, gint64{width} + beyond, 16);
  for (int p = 0; p < planes_; ++p) {
    const auto plane = static_cast<guint>(p);
    needed_[p] = is_palette(format, plane) ? palette_bytes : plane_line_bytes(format, plane, width);
    touched_[p] = is_palette(format, plane) ? palette_bytes : GST_VIDEO_INFO_PLANE_STRIDE(&wide, plane) + beyond;
  }
}

guint8 *MappedLines::place(int plane, int line) const {
  auto *data = static_cast<guint8 *>(frame_.data[plane]);
  if (is_palette(*frame_.info.finfo, static_cast<guint>(plane))) return data;
  return data + std::ptrdiff_t{line} * GST_VIDEO_FRAME_PLANE_STRIDE(&frame_, plane);
}

MappedLines::Line MappedLines::line(const std::array<int, GST_VIDEO_MAX_PLANES> &lines, int y, bool copy,
                                    Room &room) const {
  Line out;
  if (tiled_) {
    std::copy_n(frame_.data, planes_, out.data);
    std::copy_n(frame_.info.stride, planes_, out.stride);
    out.y = y;
    return out;
  }
  // With strides of 0 the functions take these lines, whatever their number.
  for (int p = 0; p < planes_; ++p) {
    guint8 *from = place(p, lines[static_cast<std::size_t>(p)]);
    const GstMapInfo &map = frame_.map[frame_.meta ? p : 0];
    const gint64 left = map.data + map.size - from;
    out.data[p] = from;
    if (!copy && left >= touched_[p]) continue;
    auto &own = room.planes[p];
    own.assign(static_cast<std::size_t>(touched_[p]), 0);
    std::memcpy(own.data(), from, static_cast<std::size_t>(std::min(left, needed_[p])));
    out.data[p] = own.data();
  }
  return out;
}

void MappedLines::put(const std::array<int, GST_VIDEO_MAX_PLANES> &lines, const Room &room) const {
  for (int p = 0; p < planes_; ++p) {
    guint8 *to = place(p, lines[static_cast<std::size_t>(p)]);
    const GstMapInfo &map = frame_.map[frame_.meta ? p : 0];
    const gint64 left = map.data + map.size - to;
    std::memcpy(to, room.planes[p].data(), static_cast<std::size_t>(std::min(left, needed_[p])));
  }
}

RowUnpacker::RowUnpacker(const GstVideoFrame &frame, int x, int width, int rows, bool fields,
                         const std::array<ComponentLines, GST_VIDEO_MAX_COMPONENTS> &lines,
                         const std::array<Component, 3> &grids)
    : format_(*frame.info.finfo),
      frame_lines_(frame, x + width),
      x_(x),
      rows_(rows),
      grain_(unpack_grain(format_)),
      deep_(unpacks_deep(format_)),
      lines_(lines) {
  // Like the samples that are read in place, deeper ones have no bits below their own. Those of less than 8 bits need
  // them: white is 255.
  int flags = format_.depth[0] > 8 ? GST_VIDEO_PACK_FLAG_TRUNCATE_RANGE : GST_VIDEO_PACK_FLAG_NONE;
  if (fields) flags |= GST_VIDEO_PACK_FLAG_INTERLACED;
  flags_ = static_cast<GstVideoPackFlags>(flags);
  for (std::size_t k = 0; k < 3; ++k) sub_x_[k] = grids[k].sub_x;
  for (guint p = 0; p < format_.n_planes && grain_ > 0 && !frame_lines_.tiled(); ++p) {
    const guint c = component_of(format_, p);
    const bool strides = !is_palette(format_, p) && has_strides(format_);
    grain_bytes_[p] = strides                  ? (grain_ >> format_.w_sub[c]) * format_.pixel_stride[c]
                      : is_palette(format_, p) ? 0
                                               : group_bytes(format_, p);
  }
}

void RowUnpacker::read(int row, int first, int n, const std::array<std::uint8_t *, 3> &out) const {
  const std::size_t k = out[0] ? 0 : out[1] ? 1 : 2;
  const int luma_row = std::min(row << lines_[k].sub_y, rows_ - 1);
  std::array<int, GST_VIDEO_MAX_PLANES> lines{};
  for (int p = 0; p < frame_lines_.planes(); ++p) {
    const ComponentLines &of = lines_[component_of(format_, static_cast<guint>(p))];
    lines[static_cast<std::size_t>(p)] = of.first + (luma_row >> of.sub_y) * of.step;
  }
  MappedLines::Room room;
  const MappedLines::Line line = frame_lines_.line(lines, lines_[0].first + luma_row * lines_[0].step, false, room);
  const int sub_x = sub_x_[k], begin = (x_ >> sub_x) + first;
  const int at_once = grain_ > 0 ? std::max(1, (block - grain_) >> sub_x) : n;
  for (int done = 0; done < n; done += at_once) {
    std::array<std::uint8_t *, 3> to = out;
    for (auto &o : to)
      if (o) o += done;
    read_part(line, (begin + done) << sub_x, std::min(at_once, n - done), sub_x, to);
  }
}

/// `n` samples from pixel `begin` of the frame on.
void RowUnpacker::read_part(const MappedLines::Line &line, int begin, int n, int sub_x,
                            const std::array<std::uint8_t *, 3> &out) const {
  const int from = grain_ > 0 ? begin / grain_ * grain_ : 0;
  const int pixels = whole_groups(format_, begin + ((n - 1) << sub_x) + 1 - from);
  alignas(16) guint8 own[(block + slack) * 8];
  std::vector<guint16> large;
  guint8 *unpacked = own;
  if (pixels > block) {
    large.resize(static_cast<std::size_t>(pixels + slack) * 4);
    unpacked = reinterpret_cast<guint8 *>(large.data());
  }
  MappedLines::Line part = line;
  for (guint p = 0; p < format_.n_planes && from > 0 && !frame_lines_.tiled(); ++p)
    part.data[p] = static_cast<guint8 *>(line.data[p]) + from / grain_ * grain_bytes_[p];
  format_.unpack_func(&format_, flags_, unpacked, part.data, part.stride, frame_lines_.tiled() ? from : 0, part.y,
                      pixels);
  const int bytes = deep_ ? 2 : 1;
  FrameView view;
  Component &c = view.component[0];
  c.pixel_stride = std::ptrdiff_t{4 * bytes} << sub_x;
  c.bytes = static_cast<std::uint8_t>(bytes);
  c.shift = deep_ ? 8 : 0;
  c.big_endian = G_BYTE_ORDER == G_BIG_ENDIAN;
  for (int k = 0; k < 3; ++k) {
    if (!out[static_cast<std::size_t>(k)]) continue;
    c.data = unpacked + (4 * (begin - from) + 1 + k) * bytes;  // alpha comes first
    read_samples(view, 0, 0, 0, n, out[static_cast<std::size_t>(k)]);
  }
}

}  // namespace csd
