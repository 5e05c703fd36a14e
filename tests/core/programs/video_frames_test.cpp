// SPDX-License-Identifier: LGPL-2.1-or-later
#include "programs/video_frames.h"

#include <gtest/gtest.h>

#include "programs/file.h"

namespace csd::programs {
namespace {

/// A 16×16 video of grey frames: frame n has luma 16 + 10·n.
std::string grey_video(int frames) {
  std::string text = "YUV4MPEG2 W16 H16 F25:1 Ip A1:1 C420jpeg\n";
  for (int n = 0; n < frames; ++n)
    text += "FRAME\n" + std::string(256, static_cast<char>(16 + 10 * n)) + std::string(128, static_cast<char>(128));
  return text;
}

void expect_frame(const Picture &picture, int number) {
  const cv::Mat &frame = picture.bgr;
  ASSERT_EQ(frame.size(), cv::Size(16, 16)) << number;
  // Luma 16…235 maps to 0…255.
  EXPECT_NEAR(frame.at<cv::Vec3b>(8, 8)[1], 10 * number * 255. / 219, 1) << number;
  EXPECT_EQ(picture.pts, number * 40000000) << number;
  EXPECT_EQ(picture.duration, 40000000) << number;
}

TEST(VideoFrames, AreGivenByNumberForwardsAndBackwards) {
  const TestFolder folder;
  VideoFrames frames(folder.write("video", grey_video(20)));
  for (const int number : {0, 0, 7, 8, 19, 3, 3, 12})
    expect_frame(frames.at(static_cast<std::uint64_t>(number)), number);
  EXPECT_TRUE(frames.at(20).bgr.empty()) << "past the end";
  EXPECT_TRUE(frames.at(500).bgr.empty());
  expect_frame(frames.at(2), 2);
}

TEST(VideoFrames, HaveTheColoursOfTheirMatrix) {
  const TestFolder folder;
  const auto near_red = [](const cv::Mat &bgr) {
    cv::Mat wrong;
    cv::absdiff(bgr, cv::Scalar(0, 0, 255), wrong);
    double most = 0;
    cv::minMaxLoc(wrong.reshape(1), nullptr, &most);
    return most <= 2;
  };
  const auto red = [](int height, char y, char u, char v) {
    const auto pixels = static_cast<std::size_t>(16 * height);
    return "YUV4MPEG2 W16 H" + std::to_string(height) + " F25:1 C420jpeg\nFRAME\n" + std::string(pixels, y) +
           std::string(pixels / 4, u) + std::string(pixels / 4, v);
  };
  EXPECT_TRUE(near_red(VideoFrames(folder.write("601", red(16, '\x51', '\x5a', '\xf0'))).at(0).bgr));
  EXPECT_TRUE(near_red(VideoFrames(folder.write("709", red(720, '\x3f', '\x66', '\xf0'))).at(0).bgr));
  std::string pixmap = "P6\n16 16\n255\n";
  for (int i = 0; i < 256; ++i) pixmap += std::string("\xff\x00\x00", 3);
  EXPECT_TRUE(near_red(VideoFrames(folder.write("rgb", pixmap)).at(0).bgr));
}

TEST(VideoFrames, DescribesTheError) {
  const TestFolder folder;
  const auto error_of = [](const std::string &file) -> std::string {
    try {
      VideoFrames{file};
    } catch (const std::runtime_error &error) {
      return error.what();
    }
    return "no error";
  };
  const std::string nowhere = folder / "nowhere";
  EXPECT_TRUE(error_of(nowhere).starts_with(nowhere + ": ")) << error_of(nowhere);
  const std::string text = folder.write("text", "no video, whatever it is called\n");
  EXPECT_TRUE(error_of(text).starts_with(text + ": ")) << error_of(text);
}

}  // namespace
}  // namespace csd::programs
