// SPDX-License-Identifier: LGPL-2.1-or-later
#include "cli/video_frames.h"

#include <gtest/gtest.h>

#include "cli/file.h"

namespace csd::cli {
namespace {

/// A video of grey frames, 16×16: frame n has luma 16 + 10·n.
std::string grey_video(int frames) {
  std::string text = "YUV4MPEG2 W16 H16 F25:1 Ip A1:1 C420jpeg\n";
  for (int n = 0; n < frames; ++n)
    text += "FRAME\n" + std::string(256, static_cast<char>(16 + 10 * n)) + std::string(128, static_cast<char>(128));
  return text;
}

void expect_frame(const cv::Mat &frame, int number) {
  ASSERT_EQ(frame.size(), cv::Size(16, 16)) << number;
  // Luma 16…235 is 0…255 (BT.601), by coarse arithmetic. The next frame is 11.6 brighter.
  EXPECT_NEAR(frame.at<cv::Vec3b>(8, 8)[1], 10 * number * 255. / 219, 4) << number;
}

TEST(VideoFrames, AreGivenByNumberForwardsAndBack) {
  const TestFolder folder;
  VideoFrames frames(folder.write("video", grey_video(20)));
  for (const int number : {0, 0, 7, 8, 19, 3, 3, 12})
    expect_frame(frames.at(static_cast<std::uint64_t>(number)), number);
  EXPECT_TRUE(frames.at(20).empty()) << "past the end";
  EXPECT_TRUE(frames.at(500).empty());
  expect_frame(frames.at(2), 2);
}

TEST(VideoFrames, SaysWhatIsWrong) {
  const TestFolder folder;
  const auto error_of = [](const std::string &file) -> std::string {
    try {
      VideoFrames(file).at(0);
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
}  // namespace csd::cli
