// SPDX-License-Identifier: LGPL-2.1-or-later
#include "overlay/overlay_painter.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "caps/frame_mapping.h"
#include "overlay/blending.h"
#include "overlay/markers.h"
#include "overlay/row_painter.h"
#include "overlay/sprite_cache.h"

namespace csd {

namespace {

NativeSprite to_native(const Sprite &sprite, const FrameView &view) {
  NativeSprite out;
  out.width = sprite.rgba.cols;
  out.height = sprite.rgba.rows;
  out.origin = sprite.origin;
  out.covered = sprite.covered;
  const std::size_t pixels = sprite.rgba.total();
  out.alpha.resize(pixels);
  for (auto &value : out.value) value.resize(pixels);
  const double y_gain = view.full_range ? 1 : 219.0 / 255, c_gain = view.full_range ? 1 : 224.0 / 255;
  const double black = view.full_range ? 0 : 16;
  std::size_t i = 0;
  for (int row = 0; row < out.height; ++row)
    for (int x = 0; x < out.width; ++x, ++i) {
      const cv::Vec4b &p = sprite.rgba(row, x);
      const double a = p[3] / 255.0;
      out.alpha[i] = p[3];
      std::array<double, 3> c{static_cast<double>(p[0]), static_cast<double>(p[1]), static_cast<double>(p[2])};
      if (view.model != ColourModel::rgb) {
        const double luma = view.kr * c[0] + (1 - view.kr - view.kb) * c[1] + view.kb * c[2];
        c = {black * a + y_gain * luma, 128 * a + c_gain * (c[2] - luma) / (2 * (1 - view.kb)),
             128 * a + c_gain * (c[0] - luma) / (2 * (1 - view.kr))};
      }
      for (std::size_t k = 0; k < 3; ++k)
        out.value[k][i] = static_cast<std::uint16_t>(std::lround(std::clamp(c[k], 0.0, 255.0) * fraction));
      out.value[3][i] = static_cast<std::uint16_t>(p[3] * fraction);  // the picture's alpha: opaque
    }
  return out;
}

/// Accesses the samples of a row in place. get() and set() use the sample's own depth.
struct ByteRow {
  guint8 *line;
  int pixel_stride, shift;
  unsigned largest;
  unsigned get(int x) const { return line[x * pixel_stride]; }
  void set(int x, unsigned v) const { line[x * pixel_stride] = static_cast<guint8>(v); }
};

/// Works on unaligned data: GStreamer's GST_READ_UINT16_LE assumes an aligned pointer, and a GstVideoMeta may have odd
/// strides.
template <typename Word, bool big_endian = false>
Word read_word(const guint8 *from) {
  Word word = 0;
  for (std::size_t i = 0; i < sizeof word; ++i)
    word = static_cast<Word>(word | static_cast<Word>(from[i]) << (8 * (big_endian ? sizeof word - 1 - i : i)));
  return word;
}
template <typename Word, bool big_endian = false>
void write_word(guint8 *to, Word word) {
  for (std::size_t i = 0; i < sizeof word; ++i)
    to[i] = static_cast<guint8>(word >> (8 * (big_endian ? sizeof word - 1 - i : i)));
}

/// Writes `v` to the bits of `largest`, from bit `shift` on, and nothing else.
template <typename Word, bool big_endian = false>
void write_bits(guint8 *at, int shift, unsigned largest, unsigned v) {
  const auto rest = static_cast<Word>(read_word<Word, big_endian>(at) & ~(static_cast<Word>(largest) << shift));
  write_word<Word, big_endian>(at, static_cast<Word>(rest | static_cast<Word>(v) << shift));
}

template <typename Word, bool big_endian>
struct WordRow {
  guint8 *line;
  int pixel_stride, shift;
  unsigned largest;
  unsigned get(int x) const { return read_word<Word, big_endian>(line + x * pixel_stride) >> shift & largest; }
  void set(int x, unsigned v) const {
    guint8 *at = line + x * pixel_stride;
    if constexpr (sizeof(Word) == 2)
      write_word<Word, big_endian>(at, static_cast<Word>(v << shift));  // the word holds only one sample
    else
      write_bits<Word, big_endian>(at, shift, largest, v);
  }
};

/// Three 10-bit samples per 32-bit little-endian word, from the low bits up.
struct Gray10Row {
  guint8 *line;
  int pixel_stride, shift;
  unsigned largest;
  guint8 *word(int x) const { return line + x / 3 * 4; }
  unsigned get(int x) const { return read_word<guint32>(word(x)) >> (10 * (x % 3)) & largest; }
  void set(int x, unsigned v) const { write_bits<guint32>(word(x), 10 * (x % 3), largest, v); }
};

/// v210: six pixels are 12 samples of that kind: U0 Y0 V0 Y1 U1 Y2 V1 Y3 U2 Y4 V2 Y5.
template <int component>
struct V210Row {
  guint8 *line;
  int pixel_stride, shift;
  unsigned largest;
  static constexpr int per_group = component == 0 ? 6 : 3;
  static int position(int x) {
    const int in_group = x % per_group;
    return x / per_group * 12 + (component == 0 ? 2 * in_group + 1 : 4 * in_group + (component == 1 ? 0 : 2));
  }
  Gray10Row all() const { return {line, pixel_stride, shift, largest}; }
  unsigned get(int x) const { return all().get(position(x)); }
  void set(int x, unsigned v) const { all().set(position(x), v); }
};

/// A component of the whole frame, to write to.
struct Target : Grid {
  const GstVideoFrame *frame = nullptr;
  guint8 *data = nullptr;
  std::ptrdiff_t stride = 0;
  SamplePlace place;
  int pixel_stride = 0;
};

template <class Row>
void blend(const Target &target, const NativeSprite &sprite, std::size_t component, const Placement &at) {
  const int first = target.line_of(at.clip.y), last = target.line_of(at.clip.y + at.clip.height - 1);
  // Fields: the chroma of the last line but one may lie below that of the last.
  const int beyond = target.fields && target.sub_y ? 1 : 0;
  for (int line = std::max(0, first - beyond); line <= last + beyond; ++line) {
    if (!has_line(*target.frame, static_cast<guint>(component), line)) break;
    const Row row{target.data + line * target.stride, target.pixel_stride, target.place.shift, target.largest};
    blend_line(row, target, sprite, component, line, at);
  }
}

/// Blends a sprite into all components of a frame in a native format.
void blend(GstVideoFrame &frame, const NativeSprite &sprite, const Placement &at) {
  const GstVideoFormatInfo &format = *frame.info.finfo;
  const SampleGroups *groups = sample_groups(format);
  for (guint c = 0; c < GST_VIDEO_FORMAT_INFO_N_COMPONENTS(&format); ++c) {
    Target t;
    t.frame = &frame;
    const guint plane = format.plane[c], depth = format.depth[c];
    if (!groups) t.place = sample_place(format, c);
    t.data = static_cast<guint8 *>(GST_VIDEO_FRAME_PLANE_DATA(&frame, plane)) + t.place.offset;
    t.stride = GST_VIDEO_FRAME_PLANE_STRIDE(&frame, plane);
    t.pixel_stride = format.pixel_stride[c];
    t.largest = (1u << depth) - 1;
    t.one = c == 3 || GST_VIDEO_FORMAT_INFO_IS_RGB(&format) ? t.largest : 255u << (depth - 8);
    t.sub_x = static_cast<int>(format.w_sub[c]);
    t.sub_y = static_cast<int>(format.h_sub[c]);
    t.fields = frame_fields(frame) != Fields::progressive;
    if (groups && groups->packing == Packing::gray10)
      blend<Gray10Row>(t, sprite, c, at);
    else if (groups && c == 0)
      blend<V210Row<0>>(t, sprite, c, at);
    else if (groups && c == 1)
      blend<V210Row<1>>(t, sprite, c, at);
    else if (groups)
      blend<V210Row<2>>(t, sprite, c, at);
    else if (t.place.bytes == 4)
      t.place.big_endian ? blend<WordRow<guint32, true>>(t, sprite, c, at)
                         : blend<WordRow<guint32, false>>(t, sprite, c, at);
    else if (t.place.bytes == 2)
      t.place.big_endian ? blend<WordRow<guint16, true>>(t, sprite, c, at)
                         : blend<WordRow<guint16, false>>(t, sprite, c, at);
    else
      blend<ByteRow>(t, sprite, c, at);
  }
}

}  // namespace

struct OverlayPainter::Impl {
  std::optional<Markers> markers;
  SpriteCache<NativeSprite> sprites;
  FrameView colours;  ///< what the cached sprites are made for

  const NativeSprite &sprite(const Feature &feature, int width) {
    const bool left = markers->text_left(feature.id, feature.x, width);
    return sprites.get(Markers::key(feature.state, feature.id, left),
                       [&] { return to_native(markers->sprite(feature.state, feature.id, left), colours); });
  }

  void prepare(const FrameView &view) {
    sprites.next_frame();
    const bool same_look = markers && markers->lines() == view.height;
    if (same_look && colours.model == view.model && colours.kr == view.kr && colours.kb == view.kb &&
        colours.full_range == view.full_range)
      return;
    sprites.clear();
    colours = view;
    colours.component = {};
    colours.reader = nullptr;
    if (!same_look) markers.emplace(view.height);
  }
};

OverlayPainter::OverlayPainter() : impl_(std::make_unique<Impl>()) {}
OverlayPainter::~OverlayPainter() = default;

int OverlayPainter::draw(GstVideoFrame &frame, const GstVideoInfo &caps, const GstVideoCropMeta *crop,
                         const Tracks &tracks) {
  const PictureArea area = picture_area(frame, caps, crop);
  if (area.width == 0) return 0;
  impl_->prepare(frame_view(frame, caps, crop));

  std::vector<PlacedSprite> sprites;
  int left = 0;
  const cv::Rect picture(area.x, area.y, area.width, area.height);
  for (const Feature &feature : tracks.features) {
    // Markers far outside are invisible, and would overflow the sums below.
    if (feature.state == FeatureState::ended || !(std::abs(feature.x) < 1e6) || !(std::abs(feature.y) < 1e6)) continue;
    const NativeSprite &sprite = impl_->sprite(feature, area.width);
    Placement at;
    at.x = area.x + static_cast<int>(std::lround(feature.x)) - sprite.origin.x;
    at.y = area.y + static_cast<int>(std::lround(feature.y)) - sprite.origin.y;
    at.clip = cv::Rect(at.x, at.y, sprite.width, sprite.height) & picture;
    if (at.clip.empty()) continue;
    if (is_native(GST_VIDEO_FRAME_FORMAT(&frame))) {
      blend(frame, sprite, at);
      continue;
    }
    sprites.push_back({sprite, at});
    if (!impl_->sprites.full()) continue;
    left += paint_rows(frame, sprites);
    sprites.clear();
  }
  return sprites.empty() ? left : left + paint_rows(frame, sprites);
}

}  // namespace csd
