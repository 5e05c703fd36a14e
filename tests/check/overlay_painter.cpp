// SPDX-License-Identifier: LGPL-2.1-or-later
#include "overlay/overlay_painter.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <memory>
#include <set>
#include <string>

#include "caps/frame_mapping.h"
#include "overlay/markers.h"
#include "overlay/row_painter.h"
#include "overlay/sprite_cache.h"
#include "scene.h"

namespace {

csd::Feature feature(csd::FeatureId id, double x, double y, csd::FeatureState state) {
  csd::Feature out;
  out.id = id, out.x = x, out.y = y, out.state = state;
  return out;
}

/// Every state, inside and over each edge, some overlapping.
csd::Tracks some_tracks(int width, int height) {
  using enum csd::FeatureState;
  csd::Tracks tracks;
  tracks.width = width, tracks.height = height;
  tracks.features = {feature(0, 20.4, 20.6, learning),  feature(7, 33, 31, tracked),    feature(19, -2, 5, occluded),
                     feature(123, width - 1, 12, lost), feature(4, 9, height - 1, out), feature(5, 50, 28, ended)};
  return tracks;
}

/// The pixels that markers may change, from the sprites' own coverage.
cv::Mat1b touched(int width, int height, const csd::PictureArea &area, const csd::Tracks &tracks) {
  cv::Mat1b mask = cv::Mat1b::zeros(height, width);
  csd::Markers markers(area.height);
  for (const csd::Feature &f : tracks.features) {
    if (f.state == csd::FeatureState::ended) continue;
    const csd::Sprite &s = markers.sprite(f.state, f.id, markers.text_left(f.id, f.x, area.width));
    for (int y = 0; y < s.rgba.rows; ++y)
      for (int x = 0; x < s.rgba.cols; ++x) {
        const int px = static_cast<int>(std::lround(f.x)) - s.origin.x + x;
        const int py = static_cast<int>(std::lround(f.y)) - s.origin.y + y;
        if (s.rgba(y, x)[3] > 0 && px >= 0 && py >= 0 && px < area.width && py < area.height)
          mask(area.y + py, area.x + px) = 1;
      }
  }
  return mask;
}

std::vector<std::uint8_t> bytes(GstBuffer *buffer) {
  std::vector<std::uint8_t> out(gst_buffer_get_size(buffer));
  gst_buffer_extract(buffer, 0, out.data(), out.size());
  return out;
}

/// Components of every pixel as GStreamer's own unpacking gives them, 16 bit.
std::vector<std::array<std::uint16_t, 4>> unpack(const GstVideoFrame &frame) {
  const GstVideoFormatInfo *format = frame.info.finfo;
  const int width = GST_VIDEO_FRAME_WIDTH(&frame), height = GST_VIDEO_FRAME_HEIGHT(&frame);
  const bool deep = GST_VIDEO_FORMAT_INFO_DEPTH(format, 0) > 8;
  const bool fields = csd::frame_fields(frame) != csd::Fields::progressive;
  std::vector<std::array<std::uint16_t, 4>> out;
  const int asked = scene::whole_width(*format, width);
  std::vector<std::uint16_t> line(static_cast<std::size_t>(asked + 16) * 4);
  for (int y = 0; y < height; ++y) {
    format->unpack_func(format, fields ? GST_VIDEO_PACK_FLAG_INTERLACED : GST_VIDEO_PACK_FLAG_NONE, line.data(),
                        frame.data, frame.info.stride, 0, y, asked);
    for (int x = 0; x < width; ++x) {
      std::array<std::uint16_t, 4> p{};
      for (std::size_t k = 0; k < 4; ++k) {
        const std::size_t at = static_cast<std::size_t>(x) * 4 + k;
        p[k] = deep ? line[at] : reinterpret_cast<const std::uint8_t *>(line.data())[at];
      }
      out.push_back(p);
    }
  }
  return out;
}

class EveryFormat : public testing::TestWithParam<GstVideoFormat> {};

std::string format_name(const testing::TestParamInfo<GstVideoFormat> &info) {
  return gst_video_format_to_string(info.param);
}

TEST_P(EveryFormat, ChangesOnlyTheMarkers) {
  const std::string name = gst_video_format_to_string(GetParam());
  for (const auto mode : {GST_VIDEO_INTERLACE_MODE_PROGRESSIVE, GST_VIDEO_INTERLACE_MODE_INTERLEAVED})
    for (const auto &[width, height] : {std::pair{160, 120}, {161, 121}, {163, 118}})
      for (const unsigned padding : {0u, 12u})
        for (const bool cropped : {false, true}) {
          if (!csd::is_native(GetParam()) && width == 160) continue;  // odd sizes are enough
          // In GStreamer's own layout (1.22) some lines end in the next one, or in the next plane.
          if ((name == "UYVP" && width % 2 == 1) || (name == "AV12" && height % 4 == 2)) continue;
          const GstVideoInfo info = scene::info_of(GetParam(), width, height, mode);
          const scene::Buffer buffer = scene::make(info, padding);
          GstVideoCropMeta crop{};
          crop.x = 13, crop.y = 7, crop.width = 101, crop.height = 81;
          const GstVideoCropMeta *used = cropped ? &crop : nullptr;
          const auto raw_before = bytes(buffer.get());
          std::vector<std::array<std::uint16_t, 4>> before, after;
          csd::PictureArea area;
          csd::Tracks tracks;
          std::size_t plane_bytes_changed = 0;
          {
            scene::Frame frame(info, buffer.get(), GST_MAP_READWRITE);
            area = csd::picture_area(frame, info, used);
            tracks = some_tracks(area.width, area.height);
            before = unpack(frame);
            csd::OverlayPainter().draw(frame, info, used, tracks);
            after = unpack(frame);
          }
          const auto raw_after = bytes(buffer.get());
          for (std::size_t i = 0; i < raw_before.size(); ++i) plane_bytes_changed += raw_before[i] != raw_after[i];
          EXPECT_GT(plane_bytes_changed, 500u);

          const cv::Mat1b mask = touched(width, height, area, tracks);
          const GstVideoFormatInfo *format = info.finfo;
          const bool yuv = GST_VIDEO_FORMAT_INFO_IS_YUV(format);
          const bool fields = mode == GST_VIDEO_INTERLACE_MODE_INTERLEAVED && scene::knows_fields(*format);
          std::size_t outside = 0, luma_changed = 0, covered = 0, edge_changed = 0;
          for (int y = 0; y < height; ++y)
            for (int x = 0; x < width; ++x) {
              const std::size_t i =
                  static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x);
              covered += mask(y, x);
              luma_changed += mask(y, x) && before[i] != after[i];
              edge_changed += x == width - 1 && before[i] != after[i];
              for (std::size_t k = 0; k < 4; ++k) {
                if (before[i][k] == after[i][k] || mask(y, x)) continue;
                // Chroma may also change where its sample belongs to a covered pixel, too.
                bool shared = false;
                if (yuv && k >= 2) {
                  const int sx = static_cast<int>(format->w_sub[1]), sy = static_cast<int>(format->h_sub[1]);
                  const int above = (2 << sy) - 1, beside = (1 << sx) - 1;
                  for (int yy = std::max(0, y - above); yy <= std::min(height - 1, y + above); ++yy)
                    for (int xx = std::max(0, x - beside); xx <= std::min(width - 1, x + beside); ++xx) {
                      const auto line = [&](int l) {
                        return sy == 0 ? l : fields ? (l >> (1 + sy)) * 2 + (l & 1) : l >> sy;
                      };
                      shared |= mask(yy, xx) && line(yy) == line(y) && xx >> sx == x >> sx;
                    }
                }
                outside += !shared;
              }
            }
          EXPECT_EQ(outside, 0u) << width << "x" << height << " fields " << fields << " crop " << cropped;
          EXPECT_GT(luma_changed, covered / 2) << "markers show";
          EXPECT_TRUE(cropped || edge_changed > 4) << "in the last column, too";
          // The planes' padding bytes are compared, too. Every changed byte must be a sample of the picture, which was
          // compared above. So at most as many bytes may differ as the covered samples have.
          EXPECT_LE(plane_bytes_changed, covered * 4 * (GST_VIDEO_FORMAT_INFO_DEPTH(format, 0) > 8 ? 4 : 2));
        }
}

/// The colour in the middle of an opaque stroke, after GStreamer's own conversion to RGB. Uses each pixel's own chroma
/// sample, because the way a converter mixes in the neighbours changed between 1.22 and 1.26.
TEST_P(EveryFormat, DrawsTheStatesColour) {
  if (GST_VIDEO_FORMAT_INFO_IS_GRAY(gst_video_format_get_info(GetParam()))) return;
  const GstVideoInfo info = scene::info_of(GetParam(), 1920, 1080);
  const GstVideoInfo rgb = scene::info_of(GST_VIDEO_FORMAT_xRGB, 1920, 1080);
  const scene::Buffer buffer = scene::allocate(info, 0, csd::is_native(GetParam()) ? 0x40 : 0),
                      shown = scene::allocate(rgb);
  csd::Tracks tracks;
  tracks.features = {feature(1, 960, 540, csd::FeatureState::tracked)};
  {
    scene::Frame frame(info, buffer.get(), GST_MAP_READWRITE);
    csd::OverlayPainter().draw(frame, info, nullptr, tracks);
  }
  scene::convert(info, buffer.get(), rgb, shown.get(), GST_VIDEO_CHROMA_MODE_NONE);
  const scene::Frame frame(rgb, shown.get(), GST_MAP_READ);
  // A circle of radius 1080/80 = 14 crosses its centre's row there; the dot is small.
  const auto *line = static_cast<const std::uint8_t *>(GST_VIDEO_FRAME_PLANE_DATA(&frame, 0)) +
                     540 * GST_VIDEO_FRAME_PLANE_STRIDE(&frame, 0);
  int nearest = 1000;
  for (int x = 960 - 17; x <= 960 - 11; ++x)
    nearest = std::min(
        nearest, std::abs(line[4 * x + 1] - 86) + std::abs(line[4 * x + 2] - 180) + std::abs(line[4 * x + 3] - 233));
  // The stroke is narrower than the chroma sample of four pixels; 5 bits are steps of 8.
  const GstVideoFormatInfo *format = info.finfo;
  EXPECT_LE(nearest, format->w_sub[1] > 1 ? 60 : format->depth[0] < 8 ? 16 : 8);
}

INSTANTIATE_TEST_SUITE_P(OverlayPainter, EveryFormat, testing::ValuesIn(csd::drawable_formats()), format_name);

/// Alpha may have two bits or sixteen; an opaque pixel has all of them set.
TEST(OverlayPainter, IsOpaqueWithAlphaOfAnyDepth) {
  for (const char *name : {"RGBA", "VUYA", "Y410", "BGR10A2_LE", "RGBA64_LE", "ARGB64"}) {
    const GstVideoInfo info = scene::info_of(gst_video_format_from_string(name), 320, 240);
    const scene::Buffer buffer = scene::allocate(info, 0, 0);
    csd::Tracks tracks;
    tracks.features = {feature(1, 160, 120, csd::FeatureState::tracked)};
    scene::Frame frame(info, buffer.get(), GST_MAP_READWRITE);
    csd::OverlayPainter().draw(frame, info, nullptr, tracks);
    unsigned least = 65535, most = 0;
    for (const auto &pixel : unpack(frame)) {
      least = std::min<unsigned>(least, pixel[0]);
      most = std::max<unsigned>(most, pixel[0]);
    }
    EXPECT_EQ(least, 0u) << name;
    // GStreamer unpacks two bits to the upper two of 16.
    const int unpacked = GST_VIDEO_INFO_COMP_DEPTH(&info, 0) > 8 ? 16 : 8, depth = GST_VIDEO_INFO_COMP_DEPTH(&info, 3);
    EXPECT_EQ(most >> (unpacked - depth), (1u << depth) - 1) << name;
  }
}

/// More sprites than the cache holds, in a format that is painted row by row.
TEST(OverlayPainter, ShowsEachOfTooManySprites) {
  const GstVideoInfo info = scene::info_of(GST_VIDEO_FORMAT_I420_10BE, 3840, 2160);
  csd::Tracks tracks;
  for (csd::FeatureId id = 0; id < 208; ++id)
    tracks.features.push_back(feature(id, 80 + id % 16 * 238, 84 + id / 16 * 165.5,
                                      id % 2 == 0 ? csd::FeatureState::tracked : csd::FeatureState::lost));
  const scene::Buffer together = scene::allocate(info, 0, 0), alone = scene::allocate(info, 0, 0);
  csd::OverlayPainter painter;
  {
    scene::Frame frame(info, together.get(), GST_MAP_READWRITE);
    painter.draw(frame, info, nullptr, tracks);
  }
  scene::Frame frame(info, alone.get(), GST_MAP_READWRITE);
  for (const csd::Feature &one : tracks.features) {
    csd::Tracks its;
    its.features = {one};
    painter.draw(frame, info, nullptr, its);
  }
  EXPECT_TRUE(bytes(together.get()) == bytes(alone.get()));
}

/// Bits that belong to no sample: packing would clear them. Such lines stay as they are, and are counted.
TEST(OverlayPainter, LeavesLinesThatPackingWouldChange) {
  const GstVideoInfo info = scene::info_of(GST_VIDEO_FORMAT_I420_10BE, 64, 48);
  const scene::Buffer buffer = scene::allocate(info, 0, 0);
  csd::Tracks tracks;
  tracks.features = {feature(1, 20, 24, csd::FeatureState::tracked)};
  scene::Frame frame(info, buffer.get(), GST_MAP_READWRITE);
  auto *line = static_cast<std::uint8_t *>(GST_VIDEO_FRAME_PLANE_DATA(&frame, 0)) + 24 * info.stride[0];
  line[2 * 60] = 0x80;  // the upper byte of a sample far from the marker
  const std::vector<std::uint8_t> before(line, line + info.stride[0]);
  EXPECT_EQ(csd::OverlayPainter().draw(frame, info, nullptr, tracks), 1);
  EXPECT_EQ(before, std::vector<std::uint8_t>(line, line + info.stride[0]));
  const auto pixels = unpack(frame);
  EXPECT_TRUE(std::any_of(pixels.begin() + 25 * 64, pixels.begin() + 26 * 64, [](const auto &p) { return p[1] > 0; }));
}

/// Two fields of 4n+2 lines, in planes without the last chroma line, one after the other; with the chroma's lines
/// upwards from the memory's begin; with U and V side by side. Each gets the same markers, and no byte beside its lines
/// changes.
TEST(OverlayPainter, PaintsTheSameIntoPlanesOfAnyLayout) {
  constexpr int width = 64, height = 46, lines = 23, beside = 512;
  for (const GstVideoFormat format : {GST_VIDEO_FORMAT_I420, GST_VIDEO_FORMAT_I420_10BE}) {
    const GstVideoInfo info = scene::info_of(format, width, height, GST_VIDEO_INTERLACE_MODE_INTERLEAVED);
    const int bytes = format == GST_VIDEO_FORMAT_I420 ? 1 : 2, luma = width * bytes, chroma = luma / 2;
    const int all = luma * height + 2 * chroma * lines;
    struct Layout {
      const char *what;
      int offset[4], stride[4];
    };
    const Layout layouts[] = {
        {"one after the other", {0, luma * height, luma * height + chroma * lines}, {luma, chroma, chroma}},
        {"upwards", {2 * chroma * lines, chroma * (lines - 1), chroma * (2 * lines - 1)}, {luma, -chroma, -chroma}},
        {"side by side", {0, luma * height, luma * height + chroma}, {luma, luma, luma}},
    };
    std::vector<guint8> first;
    for (const Layout &layout : layouts) {
      std::vector<guint8> memory(static_cast<std::size_t>(beside + all + beside));
      const scene::Buffer buffer(gst_buffer_new_wrapped_full(GST_MEMORY_FLAG_NO_SHARE, memory.data(), memory.size(),
                                                             beside, static_cast<gsize>(all), nullptr, nullptr));
      gsize offset[4] = {};
      gint stride[4] = {};
      for (int p = 0; p < 3; ++p) {
        offset[p] = static_cast<gsize>(layout.offset[p]);
        stride[p] = layout.stride[p];
      }
      gst_buffer_add_video_meta_full(buffer.get(), GST_VIDEO_FRAME_FLAG_NONE, format, width, height, 3, offset, stride);
      csd::Tracks tracks;
      tracks.features = {feature(1, 20, 8, csd::FeatureState::tracked), feature(2, 40, 42, csd::FeatureState::tracked)};
      std::vector<guint8> planes;
      {
        csd::MappedFrame frame(info, buffer.get(), GST_MAP_READWRITE);
        csd::OverlayPainter().draw(*frame, info, nullptr, tracks);
        const csd::FrameView view = csd::frame_view(*frame, info);  // no TFF: the bottom field
        for (std::size_t k = 1; k < 3 && bytes == 1; ++k) {
          const auto *last =
              view.component[k].data + ((view.rows - 1) >> view.component[k].sub_y) * view.component[k].row_stride;
          EXPECT_GE(last, memory.data() + beside) << layout.what;
          EXPECT_LE(last + chroma, memory.data() + beside + all) << layout.what;
        }
        for (int p = 0; p < 3; ++p)
          for (int y = 0; y < (p == 0 ? height : lines); ++y) {
            const auto *line = static_cast<const guint8 *>(frame->data[p]) + y * stride[p];
            planes.insert(planes.end(), line, line + (p == 0 ? luma : chroma));
          }
      }
      if (first.empty()) first = planes;
      EXPECT_TRUE(planes == first) << layout.what << ", " << gst_video_format_to_string(format);
      EXPECT_EQ(std::count(memory.begin(), memory.begin() + beside, 0), beside) << layout.what;
      EXPECT_EQ(std::count(memory.end() - beside, memory.end(), 0), beside) << layout.what;
      const auto chroma_begin = planes.begin() + luma * height;
      EXPECT_GT(planes.end() - chroma_begin - std::count(chroma_begin, planes.end(), 0), 50) << layout.what;
    }
  }
}

/// An index into a palette has no neighbour to blend with.
TEST(OverlayPainter, DrawsIntoAllButAPalette) {
  const auto all = csd::pixel_formats();
  for (const GstVideoFormat format : all) {
    const auto &drawable = csd::drawable_formats();
    const bool draws = std::find(drawable.begin(), drawable.end(), format) != drawable.end();
    EXPECT_EQ(draws, format != GST_VIDEO_FORMAT_RGB8P) << gst_video_format_to_string(format);
  }
}

TEST(OverlayPainter, SurvivesImpossiblePositionsAndSizes) {
  for (const auto &[width, height] : {std::pair{1, 1}, {3, 2}, {16, 2160}}) {
    const GstVideoInfo info = scene::info_of(GST_VIDEO_FORMAT_I420, width, height);
    const scene::Buffer buffer = scene::make(info);
    scene::Frame frame(info, buffer.get(), GST_MAP_READWRITE);
    csd::Tracks tracks;
    for (const double v : {0.0, -1e9, 1e300, -0.5})
      tracks.features.push_back(feature(csd::no_feature - 1, v, -v, csd::FeatureState::tracked));
    csd::OverlayPainter().draw(frame, info, nullptr, tracks);
  }
}

struct Megabyte {
  std::shared_ptr<int> token;  ///< one object for all: its use count tells how many sprites exist
  std::uint64_t key = 0;
  std::size_t bytes() const { return 1 << 20; }
};

TEST(SpriteCache, IsBoundedInBytesButKeepsTheLastFramesSprites) {
  constexpr std::uint64_t room = csd::SpriteCache<Megabyte>::max_bytes >> 20;
  constexpr std::uint64_t least = csd::SpriteCache<Megabyte>::min_frames;
  const auto token = std::make_shared<int>();
  csd::SpriteCache<Megabyte> cache;
  const auto made_for = [&](std::uint64_t first, std::uint64_t count) {
    std::uint64_t made = 0;
    cache.next_frame();
    for (std::uint64_t key = first; key < first + count; ++key) {
      const auto make = [&] {
        ++made;
        return Megabyte{token, key};
      };
      EXPECT_EQ(cache.get(key, make).key, key);
      EXPECT_LE(token.use_count() - 1, static_cast<long>(room) + 1) << "and the one that did not fit";
    }
    return made;
  };
  EXPECT_EQ(made_for(0, room), room);
  EXPECT_EQ(made_for(0, room), 0u);
  EXPECT_EQ(made_for(0, room + 5), 5u) << "only those that do not fit";
  EXPECT_EQ(made_for(0, room + 5), 5u) << "the same in every frame";
  EXPECT_EQ(made_for(100, 10), 10u) << "no room for others yet";
  EXPECT_EQ(made_for(100, 10), 10u) << "sprites not in the last frame make room";
  EXPECT_EQ(made_for(100, 10), 0u);
  for (std::uint64_t frame = 0; frame < least; ++frame) EXPECT_EQ(made_for(100, 1), 0u);
  EXPECT_EQ(token.use_count() - 1, 10) << "they may come back";
  for (std::uint64_t frame = 0; frame < least; ++frame) EXPECT_EQ(made_for(100, 1), 0u);
  EXPECT_EQ(token.use_count() - 1, 1) << "sprites unused for so long are gone";
  cache.clear();
  EXPECT_EQ(token.use_count(), 1);
  EXPECT_EQ(made_for(100, 10), 10u);
}

TEST(Markers, StatesDifferInShapeAlone) {
  for (const int lines : {240, 480, 720, 2160}) {
    csd::Markers markers(lines);
    std::vector<cv::Mat1b> coverage;
    for (std::size_t s = 0; s + 1 < csd::feature_states; ++s) {
      const csd::Sprite &sprite = markers.sprite(static_cast<csd::FeatureState>(s), 42);
      cv::Mat1b alpha(sprite.rgba.size());
      // Where the bright core is, since alpha includes the halo.
      for (int y = 0; y < alpha.rows; ++y)
        for (int x = 0; x < alpha.cols; ++x) alpha(y, x) = sprite.rgba(y, x)[1] > 70 ? 255 : 0;
      for (const cv::Mat1b &other : coverage) {
        ASSERT_EQ(other.size(), alpha.size());
        EXPECT_GE(cv::norm(other, alpha, cv::NORM_L1) / 255, 8) << lines << " lines, state " << s;
      }
      coverage.push_back(alpha);
    }
  }
}

TEST(Markers, PutTheIdInsideThePicture) {
  csd::Markers markers(480);
  EXPECT_FALSE(markers.text_left(123, 320, 640));
  EXPECT_TRUE(markers.text_left(123, 630, 640));
  EXPECT_FALSE(markers.text_left(123, 5, 10)) << "no room on either side";
  const csd::Sprite right = markers.sprite(csd::FeatureState::tracked, 123);
  const csd::Sprite left = markers.sprite(csd::FeatureState::tracked, 123, true);
  EXPECT_LT(right.origin.x, right.rgba.cols / 2);
  EXPECT_GT(left.origin.x, left.rgba.cols / 2);
  EXPECT_LE(630 - left.origin.x + left.rgba.cols - 640, 2) << "only the shape's edge may be outside";
}

TEST(Markers, GrowWithThePicture) {
  csd::Markers small(240), large(2160);
  EXPECT_GE(small.sprite(csd::FeatureState::tracked, 1).rgba.rows, 11);
  EXPECT_GT(large.sprite(csd::FeatureState::tracked, 1).rgba.rows,
            4 * small.sprite(csd::FeatureState::tracked, 1).rgba.rows);
}

}  // namespace

int main(int argc, char **argv) {
  gst_init(&argc, &argv);
  testing::InitGoogleTest(&argc, argv);
  return RUN_ALL_TESTS();
}
