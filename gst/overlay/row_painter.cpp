// SPDX-License-Identifier: LGPL-2.1-or-later
#include "overlay/row_painter.h"

#include <random>

#include "caps/formats.h"
#include "caps/frame_mapping.h"
#include "caps/row_unpacker.h"

namespace csd {

namespace {

/// Component `k` of unpacked pixels. Alpha comes first in memory and is component 3. A subsampled component has the
/// same value in all pixels of its sample.
template <class Word>
struct UnpackedRow {
  Word *first;
  int sub_x, width;
  UnpackedRow(Word *pixels, std::size_t k, int sub, int columns)
      : first(pixels + (k + 1) % 4), sub_x(sub), width(columns) {}
  unsigned get(int column) const { return first[4 * (column << sub_x)]; }
  void set(int column, unsigned v) const {
    const int end = std::min((column + 1) << sub_x, width);
    for (int x = column << sub_x; x < end; ++x) first[4 * x] = static_cast<Word>(v);
  }
};

/// A small frame of random bytes.
struct RandomFrame {
  static constexpr int width = 96, height = 64;
  const GstVideoFormatInfo &format;
  GstVideoInfo info;
  std::vector<guint8> bytes;
  gpointer data[GST_VIDEO_MAX_PLANES] = {};

  explicit RandomFrame(const GstVideoFormatInfo &of) : format(of) {
    gst_video_info_set_format(&info, format.format, width, height);
    bytes.resize(info.size);
    std::minstd_rand random(1);
    for (guint8 &b : bytes) b = static_cast<guint8>(random() >> 8);
    for (guint p = 0; p < format.n_planes; ++p) data[p] = bytes.data() + info.offset[p];
  }
  std::vector<guint64> unpack(int y, int flags) const {
    std::vector<guint64> line(width + 16);
    format.unpack_func(&format, static_cast<GstVideoPackFlags>(flags), line.data(), data, info.stride, 0, y, width);
    return line;
  }
};

/// Whether packing gives back all bytes.
bool gives_back(const GstVideoFormatInfo &format) {
  RandomFrame frame(format);
  const std::vector<guint8> before = frame.bytes;
  for (int y = 0; y < RandomFrame::height; ++y) {
    const auto line = frame.unpack(y, GST_VIDEO_PACK_FLAG_TRUNCATE_RANGE);
    format.pack_func(&format, GST_VIDEO_PACK_FLAG_TRUNCATE_RANGE, const_cast<guint64 *>(line.data()), 0, frame.data,
                     frame.info.stride, GST_VIDEO_CHROMA_SITE_NONE, y, RandomFrame::width);
  }
  return before == frame.bytes;
}

/// Whether the functions know chroma lines of fields: NV12_10BE_8L128's (1.22), MT2110T's and MT2110R's (1.26) don't.
bool knows_fields(const GstVideoFormatInfo &format) {
  const RandomFrame frame(format);
  return frame.unpack(1, GST_VIDEO_PACK_FLAG_NONE) != frame.unpack(1, GST_VIDEO_PACK_FLAG_INTERLACED);
}

/// Unpacks and packs lines of a frame.
class RowPainter {
 public:
  explicit RowPainter(GstVideoFrame &frame)
      : frame_(frame), format_(*frame.info.finfo), lines_(frame, frame.info.width), deep_(unpacks_deep(format_)) {
    width_ = whole_groups(format_, frame.info.width);
    pixels_.resize(static_cast<std::size_t>(width_ + 16));
    // Samples of less than 8 bits need all bits, so that white is 255.
    const bool fields = frame_fields(frame) != Fields::progressive && (!lines_.tiled() || knows_fields(format_));
    int flags = format_.depth[0] > 8 ? GST_VIDEO_PACK_FLAG_TRUNCATE_RANGE : GST_VIDEO_PACK_FLAG_NONE;
    if (fields && lines_.tiled()) flags |= GST_VIDEO_PACK_FLAG_INTERLACED;
    flags_ = static_cast<GstVideoPackFlags>(flags);
    for (guint c = 0; c < format_.n_components; ++c) {
      Grid &g = grids_[c];
      g.sub_x = static_cast<int>(format_.w_sub[c]), g.sub_y = static_cast<int>(format_.h_sub[c]);
      g.largest = deep_ ? 65535 : 255;
      g.one = c == 3 || GST_VIDEO_FORMAT_INFO_IS_RGB(&format_) ? g.largest : deep_ ? 255u << 8 : 255u;
      g.fields = fields;
    }
  }

  /// Returns false if the line must stay as it is.
  bool paint(int y, const std::vector<PlacedSprite> &sprites) {
    const bool touches =
        std::any_of(sprites.begin(), sprites.end(), [&](const PlacedSprite &s) { return meets(s, y); });
    if (!touches) return true;
    std::array<int, GST_VIDEO_MAX_PLANES> lines{};
    for (guint c = 0; c < format_.n_components; ++c) {
      const int its = lines[format_.plane[c]] = grids_[c].line_of(y);
      if (!lines_.tiled() && !has_line(frame_, c, its)) return false;
    }
    MappedLines::Line line = lines_.line(lines, y, true, before_);
    // With a stride of 0 the number of the line tells only whether its chroma is packed, too.
    if (!lines_.tiled()) line.y = packs_chroma(y) ? 0 : 1;
    format_.unpack_func(&format_, flags_, pixels_.data(), line.data, line.stride, 0, line.y, width_);
    MappedLines::Line to = line;
    if (!lines_.tiled()) {
      for (int p = 0; p < lines_.planes(); ++p) {
        after_.planes[p] = before_.planes[p];
        to.data[p] = after_.planes[p].data();
      }
      pack(to);
      for (int p = 0; p < lines_.planes(); ++p)
        if (after_.planes[p] != before_.planes[p]) return false;
    }
    for (const PlacedSprite &s : sprites) {
      if (!meets(s, y)) continue;
      if (deep_)
        blend(reinterpret_cast<guint16 *>(pixels_.data()), y, s);
      else
        blend(reinterpret_cast<guint8 *>(pixels_.data()), y, s);
    }
    pack(to);
    if (!lines_.tiled()) lines_.put(lines, after_);
    return true;
  }

 private:
  void pack(MappedLines::Line &to) {
    format_.pack_func(&format_, flags_, pixels_.data(), 0, to.data, to.stride, GST_VIDEO_CHROMA_SITE_NONE, to.y,
                      width_);
  }

  /// Packing writes chroma with the first of the lines that have it.
  bool packs_chroma(int y) const { return grids_[1].frame_line(grids_[1].line_of(y), 0) == y; }

  /// Whether line `y` shows the sprite, or has its chroma.
  bool meets(const PlacedSprite &s, int y) const {
    const auto inside = [&](int line) { return line >= s.at.clip.y && line < s.at.clip.y + s.at.clip.height; };
    bool any = inside(y);
    if (packs_chroma(y))
      for (int n = 1; n < 1 << grids_[1].sub_y; ++n) any |= inside(grids_[1].frame_line(grids_[1].line_of(y), n));
    return any;
  }

  template <class Word>
  void blend(Word *pixels, int y, const PlacedSprite &s) const {
    const std::size_t components = GST_VIDEO_FORMAT_INFO_IS_GRAY(&format_) ? 1 : format_.n_components;
    for (std::size_t c = 0; c < components; ++c) {
      const Grid &grid = grids_[c];
      const int line = grid.line_of(y);
      if (grid.sub_y > 0 && !packs_chroma(y)) continue;
      blend_line(UnpackedRow<Word>(pixels, c, grid.sub_x, width_), grid, s.sprite, c, line, s.at);
    }
  }

  GstVideoFrame &frame_;
  const GstVideoFormatInfo &format_;
  const MappedLines lines_;
  const bool deep_;
  int width_;
  GstVideoPackFlags flags_;
  std::array<Grid, GST_VIDEO_MAX_COMPONENTS> grids_;
  std::vector<std::uint64_t> pixels_;  ///< of four components, 16 bit or less
  MappedLines::Room before_, after_;
};

}  // namespace

const std::vector<GstVideoFormat> &drawable_formats() {
  static const std::vector<GstVideoFormat> formats = [] {
    std::vector<GstVideoFormat> out;
    for (const GstVideoFormat format : pixel_formats()) {
      const GstVideoFormatInfo &info = *gst_video_format_get_info(format);
      const bool packs = info.pack_func && !GST_VIDEO_FORMAT_INFO_HAS_PALETTE(&info);
      if (is_native(format) || (packs && (!GST_VIDEO_FORMAT_INFO_IS_TILED(&info) || gives_back(info))))
        out.push_back(format);
    }
    return out;
  }();
  return formats;
}

GstCaps *drawable_caps() {
  static GstCaps *const caps = [] {
    GstCaps *all = caps_of(drawable_formats());
    GST_MINI_OBJECT_FLAG_SET(all, GST_MINI_OBJECT_FLAG_MAY_BE_LEAKED);
    return all;
  }();
  return gst_caps_ref(caps);
}

int paint_rows(GstVideoFrame &frame, const std::vector<PlacedSprite> &sprites) {
  RowPainter painter(frame);
  int left = 0;
  for (int y = 0; y < GST_VIDEO_FRAME_HEIGHT(&frame); ++y) left += !painter.paint(y, sprites);
  return left;
}

}  // namespace csd
