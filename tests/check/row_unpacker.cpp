// SPDX-License-Identifier: LGPL-2.1-or-later
// Every format of the running GStreamer: the caps, and frames that are read through GStreamer's own unpacking.
#include "caps/row_unpacker.h"

#include <gtest/gtest.h>
#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <random>
#include <stdexcept>
#include <string>
#include <vector>

#include "caps/frame_mapping.h"
#include "image/samples.h"
#include "image/work_frame.h"
#include "scene.h"

namespace {

using csd::FrameView;

/// Memory whose first byte and last byte lie at pages that can't be touched: a fault ends the test.
class Guarded {
 public:
  /// With `at_end` the last byte is the last before a forbidden page, else the first the first after one.
  Guarded(gsize size, bool at_end) : size_(size) {
    const auto page = static_cast<gsize>(sysconf(_SC_PAGESIZE));
    inside_ = (size + page - 1) / page * page;
    all_ = inside_ + 2 * page;
    base_ = static_cast<guint8 *>(mmap(nullptr, all_, PROT_NONE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0));
    if (base_ == MAP_FAILED) throw std::runtime_error("no memory");
    if (mprotect(base_ + page, inside_, PROT_READ | PROT_WRITE) != 0) throw std::runtime_error("no memory");
    data_ = base_ + page + (at_end ? inside_ - size : 0);
  }
  ~Guarded() { munmap(base_, all_); }
  Guarded(const Guarded &) = delete;
  Guarded &operator=(const Guarded &) = delete;
  guint8 *data() const { return data_; }
  scene::Buffer buffer() const {
    return scene::Buffer(
        gst_buffer_new_wrapped_full(static_cast<GstMemoryFlags>(0), data_, size_, 0, size_, nullptr, nullptr));
  }

 private:
  guint8 *base_, *data_;
  gsize size_, inside_, all_;
};

/// Random bytes, without bits above the samples' depth: GStreamer's own functions differ in what they make of these.
void fill(guint8 *data, gsize size, const GstVideoFormatInfo &format, unsigned seed) {
  std::mt19937 random(seed);
  std::generate_n(data, size, [&] { return static_cast<guint8>(random()); });
  const guint depth = format.depth[0];
  if (format.n_planes >= 3 && depth > 8 && depth < 16)
    for (gsize i = GST_VIDEO_FORMAT_INFO_IS_LE(&format) ? 1 : 0; i < size; i += 2)
      data[i] &= static_cast<guint8>((1u << (depth - 8)) - 1);
}

int components(const FrameView &view) {
  return view.model == csd::ColourModel::gray ? 1 : 3;
}

std::vector<std::uint8_t> samples(const FrameView &view, int k, int row) {
  std::vector<std::uint8_t> out(static_cast<std::size_t>(csd::component_columns(view, k)));
  csd::read_samples(view, k, row, 0, static_cast<int>(out.size()), out.data());
  return out;
}

class EveryFormat : public testing::TestWithParam<GstVideoFormat> {
 protected:
  const GstVideoFormatInfo &format_ = *gst_video_format_get_info(GetParam());
};

std::string format_name(const testing::TestParamInfo<GstVideoFormat> &info) {
  return gst_video_format_to_string(info.param);
}

constexpr std::array<GstVideoInterlaceMode, 3> modes{
    GST_VIDEO_INTERLACE_MODE_PROGRESSIVE, GST_VIDEO_INTERLACE_MODE_INTERLEAVED, GST_VIDEO_INTERLACE_MODE_MIXED};

/// The two ways to read a format know nothing of each other.
TEST_P(EveryFormat, GivesTheSameSamplesBothWays) {
  if (!csd::is_native(GetParam())) return;
  for (const auto mode : modes)
    for (const bool cropped : {false, true})
      for (const bool interlaced : {false, true}) {
        const GstVideoInfo info = scene::info_of(GetParam(), 75, 38, mode);
        const scene::Buffer buffer = scene::allocate(info, 4);
        GstMapInfo map;
        ASSERT_TRUE(gst_buffer_map(buffer.get(), &map, GST_MAP_WRITE));
        fill(map.data, map.size, format_, 1);
        gst_buffer_unmap(buffer.get(), &map);
        if (interlaced) GST_BUFFER_FLAG_SET(buffer.get(), GST_VIDEO_BUFFER_FLAG_INTERLACED);
        GstVideoCropMeta crop{};
        crop.x = 13, crop.y = 5, crop.width = 41, crop.height = 22;
        csd::MappedFrame frame(info, buffer.get(), GST_MAP_READ);
        FrameView native = csd::frame_view(*frame, info, cropped ? &crop : nullptr);
        const FrameView unpacked = csd::unpacked_view(*frame, info, cropped ? &crop : nullptr);
        native.open_range = false;
        ASSERT_FALSE(native.reader);
        ASSERT_TRUE(unpacked.reader);
        EXPECT_EQ(native.rows, unpacked.rows);
        EXPECT_EQ(native.row_step, unpacked.row_step);
        EXPECT_EQ(native.row_offset, unpacked.row_offset);
        for (int k = 0; k < components(native); ++k) {
          ASSERT_EQ(csd::component_rows(native, k), csd::component_rows(unpacked, k));
          ASSERT_EQ(csd::component_columns(native, k), csd::component_columns(unpacked, k));
          for (int row = 0; row < csd::component_rows(native, k); ++row)
            // v210 that begins within a chroma sample rounds this one's place down, the other up.
            ASSERT_EQ(samples(native, k, row), samples(unpacked, k, row))
                << "component " << k << " row " << row << " mode " << mode << (cropped ? " cropped" : "");
        }
        csd::WorkFrame one, other;
        cv::Mat a, b;
        one.load(native, 16), other.load(unpacked, 16);
        EXPECT_EQ(cv::norm(one.luma(), other.luma(), cv::NORM_INF), 0);
        one.gather_bgr({-2, -2, 30, 20}, a), other.gather_bgr({-2, -2, 30, 20}, b);
        EXPECT_EQ(cv::norm(a, b, cv::NORM_INF), 0);
        one.gather_least(a), other.gather_least(b);
        EXPECT_EQ(cv::norm(a, b, cv::NORM_INF), 0);
        one.load(native), other.load(unpacked);
        EXPECT_EQ(cv::norm(one.luma(), other.luma(), cv::NORM_INF), 0);
        one.gather_least(a), other.gather_least(b);
        EXPECT_EQ(cv::norm(a, b, cv::NORM_INF), 0);
      }
}

/// Windows of a row, and all components at once, as the whole row.
TEST_P(EveryFormat, ReadsAnyPartOfARow) {
  const GstVideoInfo info = scene::info_of(GetParam(), 1301, 6);
  const scene::Buffer buffer = scene::allocate(info);
  GstMapInfo map;
  ASSERT_TRUE(gst_buffer_map(buffer.get(), &map, GST_MAP_WRITE));
  fill(map.data, map.size, format_, 2);
  gst_buffer_unmap(buffer.get(), &map);
  csd::MappedFrame frame(info, buffer.get(), GST_MAP_READ);
  const FrameView view = csd::unpacked_view(*frame, info);
  for (int k = 0; k < components(view); ++k) {
    const int row = csd::component_rows(view, k) - 1, columns = csd::component_columns(view, k);
    const auto whole = samples(view, k, row);
    for (const auto &[first, n] : {std::pair{0, 1},
                                   {columns - 1, 1},
                                   {3, 61},
                                   {65, 7},
                                   {127, 130},
                                   {2, columns - 2},
                                   {columns / 2, columns / 2}}) {
      std::vector<std::uint8_t> part(static_cast<std::size_t>(n));
      csd::read_samples(view, k, row, first, n, part.data());
      ASSERT_TRUE(std::equal(part.begin(), part.end(), whole.begin() + first)) << k << ' ' << first << ' ' << n;
    }
  }
  if (view.model != csd::ColourModel::rgb) return;
  std::array<std::vector<std::uint8_t>, 3> all;
  for (auto &one : all) one.resize(100);
  csd::read_samples(view, 4, 17, 100, {all[0].data(), all[1].data(), all[2].data()});
  for (int k = 0; k < 3; ++k) {
    const auto whole = samples(view, k, 4);
    EXPECT_TRUE(std::equal(all[static_cast<std::size_t>(k)].begin(), all[static_cast<std::size_t>(k)].end(),
                           whole.begin() + 17));
  }
}

/// Reads all of a view, so that a byte outside the frame's memory ends the test.
void read_all(const FrameView &view) {
  for (int k = 0; view.rows > 0 && k < components(view); ++k)
    for (int row = 0; row < csd::component_rows(view, k); ++row) samples(view, k, row);
}

/// GStreamer's own layout, which has no byte too many.
TEST_P(EveryFormat, ReadsNoByteOutsideTheFrame) {
  for (const auto mode : modes)
    for (const auto &[width, height] : {std::pair{64, 48}, {34, 50}, {35, 51}, {1, 1}, {2, 3}, {5, 2}, {7, 6}}) {
      const GstVideoInfo info = scene::info_of(GetParam(), width, height, mode);
      for (const bool at_end : {true, false}) {
        const Guarded memory(info.size, at_end);
        fill(memory.data(), info.size, format_, 3);
        const scene::Buffer buffer = memory.buffer();
        csd::MappedFrame frame(info, buffer.get(), GST_MAP_READ);
        read_all(csd::unpacked_view(*frame, info));
        GstVideoCropMeta crop{};
        crop.x = crop.y = 1, crop.width = crop.height = G_MAXUINT;
        read_all(csd::unpacked_view(*frame, info, &crop));
      }
    }
}

/// Whatever a GstVideoMeta says, a frame is refused, or no byte outside its memory is read.
TEST_P(EveryFormat, ReadsNoByteOutsideAHostileFrame) {
  std::mt19937 random(4);
  const auto one_of = [&](std::initializer_list<gint64> values) { return std::data(values)[random() % values.size()]; };
  int taken = 0, refused = 0;
  for (int i = 0; i < 100; ++i) {
    const auto mode = modes[random() % modes.size()];
    const int width = static_cast<int>(1 + random() % 70), height = static_cast<int>(1 + random() % 70);
    const GstVideoInfo info = scene::info_of(GetParam(), width, height, mode);
    const auto size = static_cast<gsize>(
        std::max<gint64>(1, static_cast<gint64>(info.size) + one_of({0, 0, 0, 1, 77, 4096, -1, -9})));
    const Guarded memory(size, random() % 2);
    fill(memory.data(), size, format_, 5);
    const scene::Buffer buffer = memory.buffer();
    gsize offset[4];
    gint stride[4];
    for (int p = 0; p < 4; ++p) {
      offset[p] = info.offset[p], stride[p] = info.stride[p];
      if (random() % 4 == 0) offset[p] += static_cast<gsize>(one_of({1, -1, 13, 64, -64, 5000, G_MAXINT64}));
      if (random() % 4 == 0)
        stride[p] += static_cast<gint>(one_of({1, -1, 4, -4, 64, -200, 1 << 16, -(1 << 16), 1 << 24}));
      if (random() % 16 == 0) stride[p] = static_cast<gint>(one_of({0, -stride[p], G_MAXINT, G_MININT, -1, 1}));
    }
    GstVideoMeta *meta =
        gst_buffer_add_video_meta_full(buffer.get(), GST_VIDEO_FRAME_FLAG_NONE, GetParam(), static_cast<guint>(width),
                                       static_cast<guint>(height), GST_VIDEO_INFO_N_PLANES(&info), offset, stride);
    // gst_buffer_add_video_meta_full() refuses some.
    if (!meta) continue;
    if (random() % 8 == 0) meta->width += static_cast<guint>(one_of({1, 7, 64, G_MAXINT}));
    if (random() % 8 == 0) meta->height += static_cast<guint>(one_of({1, 7, 64, G_MAXINT}));
    try {
      csd::MappedFrame frame(info, buffer.get(), GST_MAP_READ);
      ++taken;
      read_all(csd::frame_view(*frame, info));
      read_all(csd::unpacked_view(*frame, info));
    } catch (const std::runtime_error &) {
      ++refused;
    }
  }
  EXPECT_GT(taken, 8);
  EXPECT_GT(refused, 8);
}

INSTANTIATE_TEST_SUITE_P(RowUnpacker, EveryFormat, testing::ValuesIn(csd::pixel_formats()), format_name);

TEST(TemplateCaps, AcceptOnlyWholePictures) {
  GstCaps *caps = csd::template_caps();
  ASSERT_EQ(gst_caps_get_size(caps), 6u);
  // The usual formats come first, in this order.
  const GValue *usual = gst_structure_get_value(gst_caps_get_structure(caps, 0), "format");
  std::string is;
  for (guint i = 0; i < gst_value_list_get_size(usual); ++i)
    is += (i ? ", " : "") + std::string(g_value_get_string(gst_value_list_get_value(usual, i)));
  EXPECT_EQ(is, CSD_USUAL_FORMATS);
  const auto takes = [&](const char *text) {
    GstCaps *asked = gst_caps_from_string(text);
    GstCaps *complete = csd::complete_caps(asked);
    const bool taken = gst_caps_is_subset(complete, caps);
    gst_caps_unref(asked);
    gst_caps_unref(complete);
    return taken;
  };
  guint count = 0;
  const GstVideoFormat *all = gst_video_formats_raw(&count);
  ASSERT_GT(count, 100u);
  for (const GstVideoFormat format : std::vector<GstVideoFormat>(all, all + count))
    for (const auto mode : {"progressive", "interleaved", "mixed"}) {
      if (std::string(gst_video_format_to_string(format)) == "DMA_DRM") continue;  // no pixels
      const std::string rest = std::string(", format=") + gst_video_format_to_string(format) +
                               ", width=640, height=480, framerate=25/1, interlace-mode=" + mode;
      EXPECT_TRUE(takes(("video/x-raw" + rest).c_str())) << rest;
      EXPECT_TRUE(takes(("video/x-raw(meta:GstVideoOverlayComposition)" + rest).c_str())) << rest;
    }
  const std::string plain = "video/x-raw, format=I420, width=640, height=480, framerate=0/1";
  EXPECT_TRUE(takes(plain.c_str())) << "no interlace-mode means progressive";
  EXPECT_FALSE(takes((plain + ", interlace-mode=fields").c_str()));
  EXPECT_FALSE(
      takes("video/x-raw(format:Interlaced), format=I420, width=640, height=480, framerate=25/1, "
            "interlace-mode=alternate"));
  EXPECT_FALSE(takes("video/x-raw(memory:GLMemory), format=RGBA, width=640, height=480, framerate=25/1"));
  for (const std::string format : {"ENCODED", "DMA_DRM", "UNKNOWN"})
    EXPECT_FALSE(takes(("video/x-raw, format=" + format + ", width=640, height=480, framerate=25/1").c_str()));
  gst_caps_unref(caps);
}

}  // namespace

int main(int argc, char **argv) {
  gst_init(&argc, &argv);
  testing::InitGoogleTest(&argc, argv);
  return RUN_ALL_TESTS();
}
