// SPDX-License-Identifier: LGPL-2.1-or-later
#include "caps/frame_mapping.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <stdexcept>
#include <string>
#include <tuple>
#include <vector>

#include "image/samples.h"
#include "image/work_frame.h"
#include "scene.h"

namespace {

using csd::FrameView;

/// R G B of a pixel of the view, by the textbook formula in double. In a gray view all three are its luma.
scene::Rgb pixel(const FrameView &view, int x, int row) {
  std::array<double, 3> c{};
  for (int k = 0; k < (view.model == csd::ColourModel::gray ? 1 : 3); ++k) {
    const bool v210 = view.packing == csd::Packing::v210;
    const csd::Component &component = view.component[static_cast<std::size_t>(k)];
    const int sub_x = v210 ? (k == 0 ? 0 : 1) : component.sub_x, sub_y = v210 ? 0 : component.sub_y;
    std::uint8_t sample = 0;
    csd::read_samples(view, k, row >> sub_y, x >> sub_x, 1, &sample);
    c[static_cast<std::size_t>(k)] = sample;
  }
  if (view.model == csd::ColourModel::rgb) return {c[0], c[1], c[2]};
  const double y = view.full_range ? c[0] : (c[0] - 16) * 255 / 219;
  if (view.model == csd::ColourModel::gray) return {y, y, y};
  const double gain = view.full_range ? 1 : 255.0 / 224;
  const double u = (c[1] - 128) * gain, v = (c[2] - 128) * gain;
  const double r = y + 2 * (1 - view.kr) * v, b = y + 2 * (1 - view.kb) * u;
  return {r, (y - view.kr * r - view.kb * b) / (1 - view.kr - view.kb), b};
}

double luma(const FrameView &view, const scene::Rgb &c) {
  return view.kr * c[0] + (1 - view.kr - view.kb) * c[1] + view.kb * c[2];
}

/// What the format's own rounding may add to an error: its step. GStreamer's palette has six levels.
double rounding(GstVideoFormat format) {
  const guint depth = gst_video_format_get_info(format)->depth[0];
  return format == GST_VIDEO_FORMAT_RGB8P ? 51 : depth < 8 ? 255.0 / ((1 << depth) - 1) : 0;
}

/// Compares all pixels of `view` with the scene from (left, top) on.
void expect_scene(const FrameView &view, int left, int top, bool fields, double mean_limit, const std::string &what,
                  double rounding = 0) {
  double colour_sum = 0, luma_worst = 0;
  for (int row = 0; row < view.rows; ++row)
    for (int x = 0; x < view.width; ++x) {
      const scene::Rgb is = pixel(view, x, row);
      const scene::Rgb should = scene::colour(left + x, top + view.row_step * row + view.row_offset, fields);
      luma_worst = std::max(luma_worst, std::abs(luma(view, is) - luma(view, should)));
      if (view.model == csd::ColourModel::gray) continue;
      for (std::size_t k = 0; k < 3; ++k) colour_sum += std::abs(is[k] - should[k]) / 3;
    }
  EXPECT_LT(luma_worst, 2.0 + rounding) << what;
  EXPECT_LT(colour_sum / (view.rows * view.width), mean_limit + rounding) << what;
}

/// An error of one chroma sample would be 4 in R (4:2:2), and more than this on average over the three.
constexpr double whole_frame = 1.8;

class EveryFormat : public testing::TestWithParam<GstVideoFormat> {
 protected:
  double step_ = rounding(GetParam());
  /// The limit for the mean colour of a frame. A chroma sample for 4×4 pixels is further from their colours. No limit
  /// where GStreamer's own packing of the scene gives other colours (seen, 1.22).
  double colour(int width, int height, bool fields = false) const {
    const std::string name = gst_video_format_to_string(GetParam());
    const bool last_column = width % 2 == 1 && (name == "VYUY" || name == "NV61");  // U for V
    const bool short_lines = width % 6 == 3 && name.ends_with("_10LE32");           // without the last V
    const bool short_plane = fields && height % 4 == 2 && name == "AV12";           // alpha where chroma should be
    const bool no_fields = fields && !scene::knows_fields(*gst_video_format_get_info(GetParam()));
    if (last_column || short_lines || short_plane || no_fields) return 255;
    return gst_video_format_get_info(GetParam())->h_sub[1] > 1 ? 1.3 * whole_frame : whole_frame;
  }
};

std::string format_name(const testing::TestParamInfo<GstVideoFormat> &info) {
  return gst_video_format_to_string(info.param);
}

TEST_P(EveryFormat, ShowsTheSameSceneWithAnyStride) {
  for (const auto &[width, height] : {std::pair{64, 48}, {65, 49}, {67, 50}, {1, 1}, {2, 3}, {7, 5}})
    for (unsigned padding : {0u, 12u}) {
      const GstVideoInfo info = scene::info_of(GetParam(), width, height);
      const scene::Buffer buffer = scene::make(info, padding);
      const scene::Frame frame(info, buffer.get(), GST_MAP_READ);
      ASSERT_TRUE(frame.mapped);
      const FrameView view = csd::frame_view(frame, info);
      EXPECT_EQ(view.width, width);
      EXPECT_EQ(view.height, height);
      EXPECT_EQ(view.rows, height);
      EXPECT_EQ(view.row_step, 1);
      EXPECT_EQ(view.row_offset, 0);
      expect_scene(view, 0, 0, false, colour(width, height),
                   std::to_string(width) + "x" + std::to_string(height) + " padded " + std::to_string(padding), step_);
    }
}

/// On whole frames of random bits, finds what GStreamer's own unpacking finds: each sample of each pixel.
TEST_P(EveryFormat, ReadsEverySampleAsGStreamerUnpacksIt) {
  constexpr int width = 67, height = 6;
  const GstVideoInfo info = scene::info_of(GetParam(), width, height);
  const scene::Buffer buffer = scene::allocate(info, 12);
  std::mt19937 random(1);
  GstMapInfo map;
  ASSERT_TRUE(gst_buffer_map(buffer.get(), &map, GST_MAP_WRITE));
  std::generate_n(map.data, map.size, [&] { return static_cast<guint8>(random()); });
  // I420_10LE and similar formats have no bits above the depth. Others may interpret stray bits there differently.
  const unsigned depth = GST_VIDEO_INFO_COMP_DEPTH(&info, 0);
  if (GST_VIDEO_INFO_N_PLANES(&info) >= 3 && depth > 8 && depth < 16)
    for (gsize i = GST_VIDEO_FORMAT_INFO_IS_LE(info.finfo) ? 1 : 0; i < map.size; i += 2)
      map.data[i] &= static_cast<guint8>((1u << (depth - 8)) - 1);
  gst_buffer_unmap(buffer.get(), &map);
  const scene::Frame frame(info, buffer.get(), GST_MAP_READ);
  const FrameView view = csd::frame_view(frame, info);
  const GstVideoFormatInfo &format = *frame.info.finfo;
  const bool deep = gst_video_format_get_info(format.unpack_format)->bits == 16;
  const auto flags = depth > 8 ? GST_VIDEO_PACK_FLAG_TRUNCATE_RANGE : GST_VIDEO_PACK_FLAG_NONE;
  const int asked = scene::whole_width(format, width);
  std::vector<std::uint16_t> line(4 * static_cast<std::size_t>(asked + 16));  // alpha and three; bytes for 8 bit
  for (int y = 0; y < height; ++y) {
    format.unpack_func(&format, flags, line.data(), frame.data, frame.info.stride, 0, y, asked);
    for (int k = 0; k < (view.model == csd::ColourModel::gray ? 1 : 3); ++k) {
      const auto c = static_cast<guint>(k);
      const int columns = csd::component_columns(view, k), across = static_cast<int>(format.w_sub[c]);
      std::vector<std::uint8_t> is(static_cast<std::size_t>(columns));
      csd::read_samples(view, k, y >> format.h_sub[c], 0, columns, is.data());
      for (int x = 0; x < columns; ++x) {
        // Its unpacking takes U for V in the last column of an odd width (seen, 1.22).
        if (GetParam() == GST_VIDEO_FORMAT_VYUY && (x << across) == width - 1) break;
        const auto at = static_cast<std::size_t>(4 * (x << across) + 1 + k);
        const int should =
            deep ? std::min((line[at] + 128) >> 8, 255) : reinterpret_cast<std::uint8_t *>(line.data())[at];
        ASSERT_EQ(is[static_cast<std::size_t>(x)], should) << "component " << k << " at " << x << ',' << y;
      }
    }
  }
}

TEST_P(EveryFormat, GivesTheWorkingImageTheSceneToo) {
  const GstVideoInfo info = scene::info_of(GetParam(), 64, 48);
  const scene::Buffer buffer = scene::make(info);
  const scene::Frame frame(info, buffer.get(), GST_MAP_READ);
  const FrameView view = csd::frame_view(frame, info);
  csd::WorkFrame work;
  work.load(view);
  ASSERT_EQ(work.size(), cv::Size(64, 48));
  cv::Mat bgr;
  work.gather_bgr(cv::Rect(0, 0, 64, 48), bgr);
  // GStreamer makes deep gray from 8-bit gray by repeating its bits, which adds up to ½.
  const double limit = view.model == csd::ColourModel::gray && GST_VIDEO_INFO_COMP_DEPTH(&info, 0) > 8 ? 2.1 : 1.6;
  double sum = 0;
  for (int y = 0; y < 48; ++y)
    for (int x = 0; x < 64; ++x) {
      scene::Rgb should = scene::colour(x, y);
      const double l = luma(view, should);
      const double y_code = view.full_range ? l : 16 + l * 219 / 255;
      const double luma_should = view.model == csd::ColourModel::rgb ? l : y_code;
      ASSERT_NEAR(work.luma().at<std::uint8_t>(y, x), luma_should, limit + step_);
      if (view.model == csd::ColourModel::gray) should = {y_code, y_code, y_code};
      const auto &is = bgr.at<cv::Vec3b>(y, x);
      for (int k = 0; k < 3; ++k) sum += std::abs(is[2 - k] - should[static_cast<std::size_t>(k)]) / 3;
    }
  EXPECT_LT(sum / (64 * 48), colour(64, 48) + step_);
}

TEST_P(EveryFormat, ShowsTheCropRectangle) {
  const double limit = colour(65, 49);
  const GstVideoInfo info = scene::info_of(GetParam(), 65, 49);
  const scene::Buffer buffer = scene::make(info, 4);
  GstVideoCropMeta *crop = gst_buffer_add_video_crop_meta(buffer.get());
  for (const auto &[x, y, width, height] : std::vector<std::array<guint, 4>>{
           {8, 6, 32, 24}, {1, 0, 20, 20}, {5, 3, 33, 21}, {6, 1, 17, 18}, {9, 7, 56, 42}, {64, 48, 1, 1}}) {
    crop->x = x, crop->y = y, crop->width = width, crop->height = height;
    const scene::Frame frame(info, buffer.get(), GST_MAP_READ);
    const FrameView view = csd::frame_view(frame, info, crop);
    EXPECT_EQ(view.width, static_cast<int>(width));
    EXPECT_EQ(view.height, static_cast<int>(height));
    const bool odd = x % 2 == 1 || y % 2 == 1;
    expect_scene(view, static_cast<int>(x), static_cast<int>(y), false, (odd ? 2 : 1) * limit,
                 std::to_string(x) + "," + std::to_string(y), step_);
  }
}

TEST_P(EveryFormat, ShowsTheFirstField) {
  for (const auto mode : {GST_VIDEO_INTERLACE_MODE_INTERLEAVED, GST_VIDEO_INTERLACE_MODE_MIXED})
    for (const auto &[width, height] : {std::pair{64, 48}, {65, 49}, {31, 50}, {33, 51}, {8, 2}})
      for (const bool top_first : {true, false})
        for (const unsigned padding : {0u, 8u}) {
          const GstVideoInfo info = scene::info_of(GetParam(), width, height, mode);
          const scene::Buffer buffer = scene::make(info, padding, true);
          if (top_first) GST_BUFFER_FLAG_SET(buffer.get(), GST_VIDEO_BUFFER_FLAG_TFF);
          const scene::Frame frame(info, buffer.get(), GST_MAP_READ);
          const FrameView view = csd::frame_view(frame, info);
          EXPECT_EQ(view.height, height);
          EXPECT_EQ(view.row_step, 2);
          EXPECT_EQ(view.row_offset, top_first ? 0 : 1);
          EXPECT_EQ(view.rows, height / 2);
          expect_scene(view, 0, 0, true, colour(width, height, true),
                       std::to_string(width) + "x" + std::to_string(height) + (top_first ? " top" : " bottom"), step_);
        }
}

TEST_P(EveryFormat, CropsFields) {
  const GstVideoInfo info = scene::info_of(GetParam(), 64, 48, GST_VIDEO_INTERLACE_MODE_INTERLEAVED);
  const scene::Buffer buffer = scene::make(info, 0, true);
  GstVideoCropMeta *crop = gst_buffer_add_video_crop_meta(buffer.get());
  crop->x = 7, crop->width = 30, crop->height = 21;
  for (guint y : {4u, 5u, 6u, 7u})
    for (const bool top_first : {true, false}) {
      crop->y = y;
      GST_BUFFER_FLAG_UNSET(buffer.get(), GST_VIDEO_BUFFER_FLAG_TFF);
      if (top_first) GST_BUFFER_FLAG_SET(buffer.get(), GST_VIDEO_BUFFER_FLAG_TFF);
      const scene::Frame frame(info, buffer.get(), GST_MAP_READ);
      const FrameView view = csd::frame_view(frame, info, crop);
      // Frame line y + row_offset must be even for the top field.
      EXPECT_EQ((y + static_cast<guint>(view.row_offset)) % 2, top_first ? 0u : 1u);
      EXPECT_EQ(view.rows, 10);
      expect_scene(view, 7, static_cast<int>(y), true, colour(64, 48, true),
                   std::to_string(y) + (top_first ? " top" : " bottom"), step_);
    }
}

TEST_P(EveryFormat, TreatsAProgressiveFrameOfAMixedStreamAsItsTopField) {
  // The same bytes as a progressive frame, and the same layout: only the caps say mixed.
  GstVideoInfo progressive = scene::info_of(GetParam(), 65, 48);
  const scene::Buffer buffer = scene::make(progressive);
  gst_buffer_add_video_meta_full(buffer.get(), GST_VIDEO_FRAME_FLAG_NONE, GetParam(), 65, 48,
                                 GST_VIDEO_INFO_N_PLANES(&progressive), progressive.offset, progressive.stride);
  const GstVideoInfo info = scene::info_of(GetParam(), 65, 48, GST_VIDEO_INTERLACE_MODE_MIXED);
  const scene::Frame frame(info, buffer.get(), GST_MAP_READ);
  const FrameView view = csd::frame_view(frame, info);
  EXPECT_EQ(view.row_step, 2);
  EXPECT_EQ(view.row_offset, 0);
  EXPECT_EQ(view.rows, 24);
  expect_scene(view, 0, 0, false, colour(65, 48), "mixed", step_);
}

INSTANTIATE_TEST_SUITE_P(FrameView, EveryFormat, testing::ValuesIn(csd::pixel_formats()), format_name);

TEST(FrameView, TakesFieldOrderFromCapsBeforeFlags) {
  GstVideoInfo info = scene::info_of(GST_VIDEO_FORMAT_I420, 16, 16, GST_VIDEO_INTERLACE_MODE_INTERLEAVED);
  const scene::Buffer buffer = scene::make(info);
  GST_VIDEO_INFO_FIELD_ORDER(&info) = GST_VIDEO_FIELD_ORDER_TOP_FIELD_FIRST;
  EXPECT_EQ(csd::frame_fields(scene::Frame(info, buffer.get(), GST_MAP_READ)), csd::Fields::top_first);
  GST_BUFFER_FLAG_SET(buffer.get(), GST_VIDEO_BUFFER_FLAG_TFF);
  GST_VIDEO_INFO_FIELD_ORDER(&info) = GST_VIDEO_FIELD_ORDER_BOTTOM_FIELD_FIRST;
  EXPECT_EQ(csd::frame_fields(scene::Frame(info, buffer.get(), GST_MAP_READ)), csd::Fields::bottom_first);
  // Mixed: only flags count, frame by frame.
  GST_VIDEO_INFO_INTERLACE_MODE(&info) = GST_VIDEO_INTERLACE_MODE_MIXED;
  EXPECT_EQ(csd::frame_fields(scene::Frame(info, buffer.get(), GST_MAP_READ)), csd::Fields::progressive);
  GST_BUFFER_FLAG_SET(buffer.get(), GST_VIDEO_BUFFER_FLAG_INTERLACED);
  EXPECT_EQ(csd::frame_fields(scene::Frame(info, buffer.get(), GST_MAP_READ)), csd::Fields::top_first);
}

TEST(FrameView, StaysInsideAPlaneWithoutTheLastChromaLine) {
  // 6 lines of I420 with 3 chroma lines, instead of the 4 that two whole fields need. V ends with the memory.
  const GstVideoInfo info = scene::info_of(GST_VIDEO_FORMAT_I420, 8, 6, GST_VIDEO_INTERLACE_MODE_INTERLEAVED);
  const scene::Buffer buffer(gst_buffer_new_allocate(nullptr, 8 * 6 + 2 * 4 * 3, nullptr));
  gsize offset[4] = {0, 48, 60, 0};
  gint stride[4] = {8, 4, 4, 0};
  gst_buffer_add_video_meta_full(buffer.get(), GST_VIDEO_FRAME_FLAG_NONE, GST_VIDEO_FORMAT_I420, 8, 6, 3, offset,
                                 stride);
  const scene::Frame frame(info, buffer.get(), GST_MAP_READ);
  ASSERT_TRUE(frame.mapped);
  const FrameView view = csd::frame_view(frame, info);  // no TFF: the bottom field
  EXPECT_EQ(view.rows, 3);
  for (std::size_t k = 1; k < 3; ++k) {
    const csd::Component &c = view.component[k];
    const auto *first = static_cast<const std::uint8_t *>(frame.data[k]);
    const std::uint8_t *last = c.data + ((view.rows - 1) >> c.sub_y) * c.row_stride + 3;
    EXPECT_GE(c.data, first);
    EXPECT_LT(last, first + 12) << k;
  }
}

TEST(FrameView, ClampsTheCropRectangle) {
  const GstVideoInfo info = scene::info_of(GST_VIDEO_FORMAT_I420, 64, 48);
  const scene::Buffer buffer = scene::make(info);
  const scene::Frame frame(info, buffer.get(), GST_MAP_READ);
  GstVideoCropMeta crop{};
  crop.x = 60, crop.y = 10, crop.width = G_MAXUINT, crop.height = 100;
  EXPECT_EQ(csd::picture_area(frame, info, &crop), (csd::PictureArea{60, 10, 4, 38}));
  crop.x = 64;
  EXPECT_EQ(csd::frame_view(frame, info, &crop).width, 0);
  EXPECT_EQ(csd::frame_view(frame, info, &crop).rows, 0);
  crop.x = G_MAXUINT;
  EXPECT_EQ(csd::picture_area(frame, info, &crop).width, 0);
}

TEST(FrameView, LeavesOutADecodersPadding) {
  const GstVideoInfo coded = scene::info_of(GST_VIDEO_FORMAT_NV12, 64, 48);
  const GstVideoInfo caps = scene::info_of(GST_VIDEO_FORMAT_NV12, 60, 44);
  const scene::Buffer buffer = scene::make(coded);
  gst_buffer_add_video_meta(buffer.get(), GST_VIDEO_FRAME_FLAG_NONE, GST_VIDEO_FORMAT_NV12, 64, 48);
  const scene::Frame frame(caps, buffer.get(), GST_MAP_READ);
  ASSERT_TRUE(frame.mapped);
  const FrameView view = csd::frame_view(frame, caps);
  EXPECT_EQ(view.width, 60);
  EXPECT_EQ(view.height, 44);
  expect_scene(view, 0, 0, false, whole_frame, "padded");
}

/// The scene as NV12 with the planes of a hardware decoder: lines longer than the picture's, of a different length in
/// each plane, lines below the picture, bytes before it; the planes in one memory or in two.
TEST(FrameView, FindsNv12PlanesWhereTheMetaSays) {
  constexpr int width = 66, height = 50;
  const GstVideoInfo info = scene::info_of(GST_VIDEO_FORMAT_NV12, width, height);
  const scene::Buffer packed = scene::make(info);
  const scene::Frame plain(info, packed.get(), GST_MAP_READ);
  gint stride[4] = {96, 128, 0, 0};
  gsize offset[4] = {40, 40 + 96 * 64 + 24, 0, 0};
  const gsize size = offset[1] + 128 * 32;
  std::vector<guint8> bytes(size, 0xee);
  for (guint plane = 0; plane < 2; ++plane)
    for (int y = 0; y < height >> plane; ++y)
      std::copy_n(static_cast<const guint8 *>(plain.data[plane]) + y * plain.info.stride[plane], width,
                  bytes.data() + offset[plane] + static_cast<gsize>(y * stride[plane]));
  for (const bool split : {false, true}) {
    const scene::Buffer buffer(gst_buffer_new());
    const gsize first = split ? offset[1] - 11 : size;  // the bytes before the second plane are in its memory
    for (const auto &[from, length] : {std::pair{gsize{0}, first}, {first, size - first}}) {
      if (length == 0) continue;
      GstMemory *memory = gst_allocator_alloc(nullptr, length, nullptr);
      gst_buffer_append_memory(buffer.get(), memory);
      gst_buffer_fill(buffer.get(), from, bytes.data() + from, length);
    }
    ASSERT_EQ(gst_buffer_n_memory(buffer.get()), split ? 2u : 1u);
    gst_buffer_add_video_meta_full(buffer.get(), GST_VIDEO_FRAME_FLAG_NONE, GST_VIDEO_FORMAT_NV12, width, height, 2,
                                   offset, stride);
    csd::MappedFrame frame(info, buffer.get(), GST_MAP_READ);
    expect_scene(csd::frame_view(*frame, info), 0, 0, false, whole_frame, split ? "two memories" : "one memory");
    GstVideoCropMeta crop{};
    crop.x = 9, crop.y = 7, crop.width = 50, crop.height = 40;
    expect_scene(csd::frame_view(*frame, info, &crop), 9, 7, false, 2 * whole_frame, "cropped");
  }
}

TEST(MappedFrame, RefusesAWrongGstVideoMeta) {
  const GstVideoInfo info = scene::info_of(GST_VIDEO_FORMAT_I420, 64, 48);
  using Lie = void (*)(GstVideoMeta &);
  const auto maps = [&info](Lie lie) {
    const scene::Buffer buffer(gst_buffer_new_allocate(nullptr, info.size, nullptr));
    gst_buffer_memset(buffer.get(), 0, 0, info.size);
    lie(*gst_buffer_add_video_meta(buffer.get(), GST_VIDEO_FRAME_FLAG_NONE, GST_VIDEO_FORMAT_I420, 64, 48));
    try {
      csd::MappedFrame(info, buffer.get(), GST_MAP_READ);
      return true;
    } catch (const std::runtime_error &) {
      return false;
    }
  };
  EXPECT_TRUE(maps([](GstVideoMeta &) {}));
  EXPECT_TRUE(maps([](GstVideoMeta &meta) { meta.offset[2] = meta.offset[1]; })) << "grey";
  EXPECT_TRUE(maps([](GstVideoMeta &meta) {
    meta.offset[0] = 47 * 64;
    meta.stride[0] = -64;
  })) << "bottom-up";
  // Beyond the memory, before it, and for another picture than in the caps.
  EXPECT_FALSE(maps([](GstVideoMeta &meta) { ++meta.offset[2]; }));
  EXPECT_FALSE(maps([](GstVideoMeta &meta) { meta.stride[2] = 4096; }));
  EXPECT_FALSE(maps([](GstVideoMeta &meta) { meta.stride[0] = -64; }));
  EXPECT_FALSE(maps([](GstVideoMeta &meta) { meta.height = 50; }));
  EXPECT_FALSE(maps([](GstVideoMeta &meta) { meta.width = 66000; }));
  EXPECT_FALSE(maps([](GstVideoMeta &meta) { meta.width = 62; }));
  EXPECT_FALSE(maps([](GstVideoMeta &meta) { meta.height = G_MAXUINT; }));
  EXPECT_FALSE(maps([](GstVideoMeta &meta) { meta.n_planes = 1; }));
  EXPECT_FALSE(maps([](GstVideoMeta &meta) { meta.format = GST_VIDEO_FORMAT_Y444; }));
}

/// Packed formats whose samples GstVideoFormatInfo doesn't locate: the last sample ends the line.
TEST(MappedFrame, KnowsTheLineLengthOfPackedFormats) {
  for (const auto &[name, width, bytes] : {std::tuple{"Y210", 6, 24},
                                           {"Y210", 5, 24},
                                           {"Y410", 5, 20},
                                           {"r210", 5, 20},
                                           {"BGR10A2_LE", 5, 20},
                                           {"GRAY10_LE32", 7, 12},
                                           {"GRAY10_LE32", 6, 8},
                                           {"v210", 7, 32},
                                           {"RGBA64_LE", 3, 24},
                                           {"GRAY16_LE", 3, 6}})
    for (const int missing : {0, 1}) {
      const GstVideoFormat format = gst_video_format_from_string(name);
      const GstVideoInfo info = scene::info_of(format, width, 2);
      const gsize size = static_cast<gsize>(100 + bytes - missing);
      const scene::Buffer buffer(gst_buffer_new());
      gst_buffer_append_memory(buffer.get(), gst_allocator_alloc(nullptr, 400, nullptr));
      gst_buffer_set_size(buffer.get(), static_cast<gssize>(size));
      gsize offset[4] = {};
      gint stride[4] = {100};
      gst_buffer_add_video_meta_full(buffer.get(), GST_VIDEO_FRAME_FLAG_NONE, format, static_cast<guint>(width), 2, 1,
                                     offset, stride);
      const auto map = [&] { csd::MappedFrame(info, buffer.get(), GST_MAP_READ); };
      if (missing)
        EXPECT_THROW(map(), std::runtime_error) << name << ' ' << width;
      else
        EXPECT_NO_THROW(map()) << name << ' ' << width;
    }
}

TEST(FrameView, KnowsMatrixAndRange) {
  const auto view_of = [](GstVideoFormat format, int height, const char *colorimetry) {
    GstVideoInfo info = scene::info_of(format, 16, height);
    if (colorimetry) gst_video_colorimetry_from_string(&info.colorimetry, colorimetry);
    const scene::Buffer buffer = scene::allocate(info);
    const scene::Frame frame(info, buffer.get(), GST_MAP_READ);
    return csd::frame_view(frame, info);
  };
  const FrameView sd = view_of(GST_VIDEO_FORMAT_I420, 576, nullptr), hd = view_of(GST_VIDEO_FORMAT_I420, 720, nullptr);
  EXPECT_NEAR(sd.kr, 0.299, 1e-6);
  EXPECT_NEAR(sd.kb, 0.114, 1e-6);
  EXPECT_NEAR(hd.kr, 0.2126, 1e-6);
  EXPECT_FALSE(hd.full_range);
  EXPECT_NEAR(view_of(GST_VIDEO_FORMAT_I420, 720, "bt2020").kr, 0.2627, 1e-6);
  EXPECT_TRUE(view_of(GST_VIDEO_FORMAT_I420, 720, "1:4:0:0").full_range);
  EXPECT_NEAR(view_of(GST_VIDEO_FORMAT_I420, 480, "2:0:0:0").kr, 0.299, 1e-6) << "unknown: by height";
  EXPECT_NEAR(view_of(GST_VIDEO_FORMAT_I420, 1080, "2:0:0:0").kr, 0.2126, 1e-6) << "unknown: by height";
  EXPECT_NEAR(view_of(GST_VIDEO_FORMAT_BGRx, 480, nullptr).kr, 0.299, 1e-6) << "as after a converter";
}

}  // namespace

int main(int argc, char **argv) {
  gst_init(&argc, &argv);
  testing::InitGoogleTest(&argc, argv);
  return RUN_ALL_TESTS();
}
