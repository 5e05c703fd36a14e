// SPDX-License-Identifier: LGPL-2.1-or-later
#include "image/work_frame.h"

#include <gtest/gtest.h>
#include <opencv2/imgproc.hpp>

#include <atomic>
#include <thread>
#include <vector>

#include "core/picture.h"

namespace csd {
namespace {

using test::is_gray;
using test::is_rgb;
using test::Layout;
using test::pack;
using test::Texture;

double largest_difference(const cv::Mat &a, const cv::Mat &b) {
  return cv::norm(a, b, cv::NORM_INF);
}

/// A texture with one colour per 2 × 2 block, so that a layout loses only bits.
cv::Mat blocky(cv::Size size) {
  const cv::Mat fine = Texture(3).render(size);
  cv::Mat out(size, CV_8UC3);
  for (int y = 0; y < size.height; ++y)
    for (int x = 0; x < size.width; ++x) out.at<cv::Vec3b>(y, x) = fine.at<cv::Vec3b>(y & ~1, x & ~1);
  return out;
}

FrameView gray_view(int width, int height, const std::uint8_t *data) {
  FrameView v;
  v.width = width;
  v.height = v.rows = height;
  v.component[0] = {.data = data, .row_stride = width};
  return v;
}

TEST(WorkFrame, AllLayoutsShowTheSamePicture) {
  for (const cv::Size size : {cv::Size(64, 48), cv::Size(37, 29)}) {
    const cv::Mat bgr = blocky(size);
    const auto reference = pack(bgr, Layout::y444);
    WorkFrame expected;
    expected.load(reference.view);
    const cv::Rect window(-4, -3, size.width + 9, size.height + 8);
    cv::Mat colour, difference;
    expected.gather_bgr(window, colour);
    expected.gather(window, {2, -1, 1}, difference);
    for (const Layout layout : test::all_layouts) {
      SCOPED_TRACE(static_cast<int>(layout));
      const auto packed = pack(bgr, layout);
      WorkFrame frame;
      frame.load(packed.view);
      ASSERT_EQ(frame.size(), size);
      cv::Mat out, space;
      frame.gather_bgr(window, out);
      frame.gather(window, {2, -1, 1}, space);
      ASSERT_EQ(out.size(), window.size());
      if (is_rgb(layout)) {
        cv::Mat extended;
        cv::copyMakeBorder(bgr, extended, 3, 5, 4, 5, cv::BORDER_REPLICATE);
        EXPECT_EQ(largest_difference(out, extended), 0);
        const FrameView &v = packed.view;
        for (int y = 0; y < size.height; ++y)
          for (int x = 0; x < size.width; ++x) {
            const cv::Vec3b &p = bgr.at<cv::Vec3b>(y, x);
            ASSERT_NEAR(frame.luma().at<std::uint8_t>(y, x), v.kr * p[2] + (1 - v.kr - v.kb) * p[1] + v.kb * p[0],
                        0.52);
          }
        EXPECT_LE(largest_difference(out, colour), 4);
      } else {
        EXPECT_EQ(largest_difference(frame.luma(), expected.luma()), 0);
        if (!is_gray(layout)) {
          EXPECT_EQ(largest_difference(out, colour), 0);
          EXPECT_EQ(largest_difference(space, difference), 0);
        }
      }
    }
  }
}

TEST(WorkFrame, GatherEqualsGatherBgrInAColourSpace) {
  const auto packed = pack(Texture(5).render({70, 41}), Layout::nv12);
  WorkFrame frame;
  frame.load(packed.view);
  const cv::Rect window(-5, 20, 66, 30);
  cv::Mat bgr, out;
  frame.gather_bgr(window, bgr);
  for (const ColourSpace &space : colour_spaces()) {
    frame.gather(window, space, out);
    for (int y = 0; y < out.rows; ++y)
      for (int x = 0; x < out.cols; ++x) {
        const cv::Vec3b p = bgr.at<cv::Vec3b>(y, x);
        ASSERT_EQ(out.at<std::uint8_t>(y, x), space.apply(p[2], p[1], p[0]));
      }
  }
}

cv::Mat darkest_of_gather_bgr(const WorkFrame &frame) {
  cv::Mat bgr, planes[3];
  frame.gather_bgr({{0, 0}, frame.size()}, bgr);
  cv::split(bgr, planes);
  return cv::min(cv::min(planes[0], planes[1]), planes[2]);
}

TEST(WorkFrame, LeastIsTheLeastOfGatherBgr) {
  for (const cv::Size size : {cv::Size(71, 41), cv::Size(200, 30)}) {
    const cv::Mat picture = Texture(6).render(size);
    for (const Layout layout : test::all_layouts) {
      SCOPED_TRACE(static_cast<int>(layout));
      const auto packed = pack(picture, layout);
      WorkFrame frame;
      frame.load(packed.view);
      cv::Mat least;
      frame.gather_least(least);
      EXPECT_EQ(largest_difference(least, darkest_of_gather_bgr(frame)), 0);
    }
  }
}

TEST(WorkFrame, LeastOfALargerPicture) {
  // Bright texture over two colours, left and right.
  cv::Mat picture(701, 90, CV_8UC3);
  const cv::Mat light = Texture(6).render(picture.size());
  for (int y = 0; y < picture.rows; ++y)
    for (int x = 0; x < picture.cols; ++x) {
      const int k = light.ptr(y)[3 * x] / 4;
      for (int c = 0; c < 3; ++c)
        picture.ptr(y)[3 * x + c] = static_cast<std::uint8_t>(k + (x < 44 ? 60 + 50 * c : 180 - 60 * c));
    }
  for (const Layout layout : test::all_layouts) {
    SCOPED_TRACE(static_cast<int>(layout));
    const auto packed = pack(picture, layout);
    WorkFrame frame;
    frame.load(packed.view);
    ASSERT_EQ(frame.size(), cv::Size(74, 576));
    cv::Mat least;
    frame.gather_least(least);
    cv::Mat difference;
    cv::absdiff(least, darkest_of_gather_bgr(frame), difference);
    EXPECT_LE(cv::norm(difference.colRange(0, 34), cv::NORM_INF), 2);
    EXPECT_LE(cv::norm(difference.colRange(39, 74), cv::NORM_INF), 2);
  }
}

TEST(WorkFrame, LumaStaysInPlaceWherePossible) {
  const cv::Mat bgr = Texture(1).render({40, 30});
  for (const Layout layout : {Layout::gray8, Layout::i420, Layout::nv21, Layout::y444}) {
    const auto packed = pack(bgr, layout);
    WorkFrame frame;
    frame.load(packed.view);
    EXPECT_EQ(frame.luma().data, packed.view.component[0].data);
  }
  auto flipped = pack(bgr, Layout::gray8);
  Component &y = flipped.view.component[0];
  WorkFrame frame;
  frame.load(flipped.view);
  cv::Mat upright;
  cv::flip(frame.luma(), upright, 0);
  y.data += 29 * y.row_stride;
  y.row_stride = -y.row_stride;
  frame.load(flipped.view);
  EXPECT_EQ(largest_difference(frame.luma(), upright), 0);
}

TEST(WorkFrame, RoundsTenBit) {
  const std::uint8_t words[] = {0x01, 0x00, 0x02, 0x00, 0xFD, 0x03, 0xFF, 0x03};  // 1, 2, 1021, 1023
  FrameView v = gray_view(4, 1, words);
  v.component[0].pixel_stride = v.component[0].bytes = v.component[0].shift = 2;
  WorkFrame frame;
  frame.load(v);
  EXPECT_EQ(std::vector<std::uint8_t>(frame.luma().begin<std::uint8_t>(), frame.luma().end<std::uint8_t>()),
            (std::vector<std::uint8_t>{0, 1, 255, 255}));
}

TEST(WorkFrame, HasItsSizeAndMapsCoordinates) {
  struct Case {
    int width, height;
    cv::Size size;
  };
  for (const Case &c :
       {Case{1280, 720, {1024, 576}}, Case{1920, 1080, {1024, 576}}, Case{640, 480, {640, 480}},
        Case{720, 576, {720, 576}}, Case{1, 1, {1, 1}}, Case{16384, 1, {16384, 1}}, Case{1, 2000, {1, 576}}}) {
    std::vector<std::uint8_t> pixels(static_cast<std::size_t>(c.width) * c.height, 77);
    WorkFrame frame;
    frame.load(gray_view(c.width, c.height, pixels.data()));
    EXPECT_EQ(frame.size(), c.size);
    EXPECT_EQ(frame.luma().at<std::uint8_t>(c.size.height - 1, c.size.width - 1), 77);
    const cv::Point2d back = frame.to_picture(frame.to_work({3.25, 8.5}));
    EXPECT_NEAR(back.x, 3.25, 1e-9);
    EXPECT_NEAR(back.y, 8.5, 1e-9);
  }
  std::vector<std::uint8_t> pixels(1280 * 720);
  WorkFrame frame;
  frame.load(gray_view(1280, 720, pixels.data()));
  EXPECT_DOUBLE_EQ(frame.scale(), 1.25);
  EXPECT_DOUBLE_EQ(frame.to_picture({0, 4}).x, 0.125);  // half a pixel of 1.25 is 0.625
  EXPECT_DOUBLE_EQ(frame.to_picture({0, 4}).y, 5.125);
}

TEST(WorkFrame, TheFieldIsIsotropicAndLiesOnItsLines) {
  const auto packed = pack(Texture(2).render({720, 576}), Layout::i420);
  FrameView v = packed.view;
  v.rows = 288;
  v.row_step = 2;
  v.row_offset = 1;
  for (Component &c : v.component) {
    c.data += c.row_stride;
    c.row_stride *= 2;
  }
  WorkFrame frame;
  frame.load(v);
  EXPECT_EQ(frame.size(), cv::Size(360, 288));
  EXPECT_DOUBLE_EQ(frame.scale(), 2);
  EXPECT_EQ(frame.to_picture({0, 0}), cv::Point2d(0.5, 1));
  EXPECT_EQ(frame.to_picture({10, 7}), cv::Point2d(20.5, 15));
  EXPECT_EQ(frame.to_work({20.5, 15}), cv::Point2d(10, 7));
  const std::uint8_t *line = packed.view.component[0].data + 15 * packed.view.component[0].row_stride;
  EXPECT_NEAR(frame.luma().at<std::uint8_t>(7, 10), (line[20] + line[21]) / 2.0, 0.51);
}

TEST(WorkFrame, AScaledPictureShowsTheSceneWhereItsCoordinatesSay) {
  const Texture texture(9);
  const cv::Mat bgr = texture.render({1280, 720});
  for (const Layout layout : {Layout::i420, Layout::y444, Layout::v210, Layout::bgrx, Layout::xrgb, Layout::bgr}) {
    const auto packed = pack(bgr, layout);
    WorkFrame frame;
    frame.load(packed.view);
    ASSERT_EQ(frame.size(), cv::Size(1024, 576));
    cv::Mat out;
    frame.gather_bgr({300, 200, 61, 61}, out);
    double sum = 0;
    for (int y = 0; y < 61; ++y)
      for (int x = 0; x < 61; ++x) {
        const cv::Point2d p = frame.to_picture({300.0 + x, 200.0 + y});
        const double exact = texture.at(p.x, p.y, 1);  // green, most of luma
        sum += std::abs(out.at<cv::Vec3b>(y, x)[1] - exact);
      }
    EXPECT_LT(sum / (61 * 61), 4) << static_cast<int>(layout);
  }
}

// 576 of 1200 lines: colour is scaled on first use, in 18 bands, and each thread begins with another band. TSan
// watches.
TEST(WorkFrame, SeveralThreadsMayGatherAtOnce) {
  for (const Layout layout : {Layout::nv12, Layout::bgrx}) {
    const auto packed = pack(Texture(6).render({90, 1200}), layout);
    const ColourSpace space{2, -1, 1};
    WorkFrame alone, shared;
    alone.load(packed.view);
    const cv::Rect whole({}, alone.size());
    ASSERT_EQ(whole.size(), cv::Size(43, 576));
    cv::Mat bgr, channel;
    alone.gather_bgr(whole, bgr);
    alone.gather(whole, space, channel);

    shared.load(packed.view);
    constexpr int threads = 4, height = 24;
    std::atomic<int> ready = 0, wrong = 0;
    std::vector<std::thread> gatherers;
    for (int t = 0; t < threads; ++t)
      gatherers.emplace_back([&, t] {
        ++ready;
        while (ready < threads) std::this_thread::yield();
        cv::Mat out;
        for (int i = 0; i < 576 / height; ++i) {
          const cv::Rect window(0, (i + t * 6) * height % 576, 43, height);
          shared.gather_bgr(window, out);
          wrong += largest_difference(out, bgr(window)) != 0;
          shared.gather(window, space, out);
          wrong += largest_difference(out, channel(window)) != 0;
        }
      });
    for (auto &thread : gatherers) thread.join();
    EXPECT_EQ(wrong, 0) << static_cast<int>(layout);
  }
}

TEST(WorkFrame, ConvertsKnownColours) {
  // BT.709: red is Y 63, U 102, V 240; white is 235, 128, 128.
  const std::uint8_t y[] = {63, 235, 16, 255}, u[] = {102, 128, 128, 128}, v[] = {240, 128, 128, 128};
  FrameView view = gray_view(4, 1, y);
  view.model = ColourModel::yuv;
  view.component[1] = {.data = u, .row_stride = 4};
  view.component[2] = {.data = v, .row_stride = 4};
  WorkFrame frame;
  frame.load(view);
  cv::Mat out;
  frame.gather_bgr({0, 0, 4, 1}, out);
  EXPECT_NEAR(out.at<cv::Vec3b>(0, 0)[2], 255, 1);
  EXPECT_NEAR(out.at<cv::Vec3b>(0, 0)[1], 0, 1);
  EXPECT_NEAR(out.at<cv::Vec3b>(0, 0)[0], 0, 1);
  EXPECT_EQ(out.at<cv::Vec3b>(0, 1), cv::Vec3b(255, 255, 255));
  EXPECT_EQ(out.at<cv::Vec3b>(0, 2), cv::Vec3b(0, 0, 0));
  EXPECT_EQ(out.at<cv::Vec3b>(0, 3), cv::Vec3b(255, 255, 255));
}

TEST(WorkFrame, RefusesAViewWithoutPixels) {
  WorkFrame frame;
  EXPECT_THROW(frame.load(FrameView{}), std::invalid_argument);
}

TEST(WorkFrame, ThePatchSizeFollowsTheLines) {
  EXPECT_EQ(default_patch_size(576), 21);
  EXPECT_EQ(default_patch_size(480), 21);
  EXPECT_EQ(default_patch_size(240), 11);  // 10.5
  EXPECT_EQ(default_patch_size(1), 9);
  for (int lines = 1; lines < 600; ++lines) EXPECT_EQ(default_patch_size(lines) % 2, 1);
}

}  // namespace
}  // namespace csd
