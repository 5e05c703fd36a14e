// SPDX-License-Identifier: LGPL-2.1-or-later
#include "programs/peers/video_source.h"

#include <gtest/gtest.h>

#include <sstream>
#include <stdexcept>

namespace csd::peers {
namespace {

std::string message_of(const std::string &y4m) {
  std::istringstream in(y4m);
  try {
    const auto source = read_y4m(in);
    Picture p;
    while (source->next(p)) {
    }
  } catch (const std::runtime_error &e) {
    return e.what();
  }
  return "";
}

TEST(Y4m, GivesPicturesAndTimes) {
  std::istringstream in(
      "YUV4MPEG2 W2 H2 F30000:1001 Ip A1:1 C420jpeg\nFRAME\n\x10\xeb\x7e\x10\x80\x80"
      "FRAME Ixyz\n\x10\x10\x10\x10\x80\x80");
  const auto source = read_y4m(in);
  Picture p;
  ASSERT_TRUE(source->next(p));
  EXPECT_EQ(p.bgr.size(), cv::Size(2, 2));
  EXPECT_EQ(p.bgr.at<cv::Vec3b>(0, 0), cv::Vec3b(0, 0, 0));        // Y 16
  EXPECT_EQ(p.bgr.at<cv::Vec3b>(0, 1), cv::Vec3b(255, 255, 255));  // Y 235
  EXPECT_NEAR(p.bgr.at<cv::Vec3b>(1, 0)[1], 128, 1);               // Y 126: 110/219 of the range
  EXPECT_EQ(p.pts, 0);
  EXPECT_EQ(p.duration, 33366666);
  ASSERT_TRUE(source->next(p));
  EXPECT_EQ(p.pts, 33366666);
  EXPECT_EQ(p.running_time, 33366666);
  EXPECT_EQ(p.stream_time, 33366666);
  EXPECT_EQ(p.duration, 33366667);  // 2·1001/30000 s = 66733333.3 ns
  EXPECT_FALSE(source->next(p));
}

TEST(Y4m, ReadsColourByTheMatrixOfTheHeight) {
  // Pure red of BT.601 in studio range is Y 81, U 90, V 240. One chroma sample for 2 × 2 pixels; odd sizes.
  std::string frame = "FRAME\n" + std::string(9, '\x51') + std::string(4, '\x5a') + std::string(4, '\xf0');
  std::istringstream sd("YUV4MPEG2 W3 H3 F25:1 C420\n" + frame);
  Picture p;
  ASSERT_TRUE(read_y4m(sd)->next(p));
  for (int y = 0; y < 3; ++y)
    for (int x = 0; x < 3; ++x) {
      const auto c = p.bgr.at<cv::Vec3b>(y, x);
      EXPECT_NEAR(c[0], 0, 2);
      EXPECT_NEAR(c[1], 0, 2);
      EXPECT_NEAR(c[2], 255, 2);
    }
  // In BT.709 it is Y 63, U 102, V 240.
  std::istringstream hd("YUV4MPEG2 W1 H720 F25:1 C444\nFRAME\n" + std::string(720, '\x3f') + std::string(720, '\x66') +
                        std::string(720, '\xf0'));
  ASSERT_TRUE(read_y4m(hd)->next(p));
  EXPECT_NEAR(p.bgr.at<cv::Vec3b>(700, 0)[2], 255, 2);
  EXPECT_NEAR(p.bgr.at<cv::Vec3b>(700, 0)[1], 0, 2);
}

TEST(Y4m, ReadsTheOtherLayouts) {
  // Where chroma is not shared, two pixels differ: neutral (128) and red (V 240).
  const auto second_red = [](const std::string &format, const std::string &chroma) {
    std::istringstream in("YUV4MPEG2 W4 H1 F25:1 " + format + "\nFRAME\n" + std::string(4, '\x51') + chroma);
    Picture p;
    EXPECT_TRUE(read_y4m(in)->next(p)) << format;
    return std::vector<int>{p.bgr.at<cv::Vec3b>(0, 0)[2], p.bgr.at<cv::Vec3b>(0, 1)[2], p.bgr.at<cv::Vec3b>(0, 2)[2]};
  };
  const auto c444 = second_red("C444", "\x80\x5a\x80\x80\x80\xf0\x80\x80");
  EXPECT_LT(c444[0], 80);
  EXPECT_GT(c444[1], 250);
  EXPECT_LT(c444[2], 80);
  const auto c422 = second_red("C422", "\x5a\x80\xf0\x80");
  EXPECT_GT(c422[0], 250);
  EXPECT_GT(c422[1], 250);
  EXPECT_LT(c422[2], 80);
  const auto c411 = second_red("C411", "\x5a\xf0");
  EXPECT_GT(c411[2], 250);
  const auto mono = second_red("Cmono", "");
  EXPECT_EQ(mono[0], mono[2]);
  EXPECT_NEAR(mono[0], 76, 1);  // (81 − 16) · 255 / 219
  std::istringstream full("YUV4MPEG2 W1 H1 F25:1 Cmono XCOLORRANGE=FULL\nFRAME\n\x51");
  Picture p;
  ASSERT_TRUE(read_y4m(full)->next(p));
  EXPECT_EQ(p.bgr.at<cv::Vec3b>(0, 0)[1], 81);
}

TEST(Y4m, DescribesTheError) {
  EXPECT_NE(message_of("RIFF....").find("does not begin with"), std::string::npos);
  EXPECT_NE(message_of("").find("does not begin with"), std::string::npos);
  EXPECT_NE(message_of("YUV4MPEG2 W2 F25:1\n").find("no width (W) or height (H)"), std::string::npos);
  EXPECT_NE(message_of("YUV4MPEG2 Wx H2\n").find("\"x\" is no width"), std::string::npos);
  EXPECT_NE(message_of("YUV4MPEG2 W2 H-2\n").find("\"-2\" is no height"), std::string::npos);
  EXPECT_NE(message_of("YUV4MPEG2 W99999 H99999\n").find("too large"), std::string::npos);
  EXPECT_NE(message_of("YUV4MPEG2 W2 H2 F25\n").find("no frame rate"), std::string::npos);
  EXPECT_NE(message_of("YUV4MPEG2 W2 H2 F25:0\n").find("no frame rate"), std::string::npos);
  EXPECT_NE(message_of("YUV4MPEG2 W2 H2 C420p10\n").find("\"C420p10\" can't be read"), std::string::npos);
  EXPECT_NE(message_of("YUV4MPEG2 W2 H2 X" + std::string(1 << 20, 'x')).find("longer than 4096 bytes"),
            std::string::npos);
  EXPECT_NE(message_of(std::string(1 << 20, 'x')).find("does not begin with"), std::string::npos);
  const std::string good = "YUV4MPEG2 W2 H2 F25:1\nFRAME\n123456";
  EXPECT_EQ(message_of("YUV4MPEG2 W2 H2 F25:1 X" + std::string(4096 - 23, 'x') + "\nFRAME\n123456"), "");
  EXPECT_NE(message_of(good + std::string(1 << 20, 'x')).find("frame 1: no FRAME"), std::string::npos);
  EXPECT_EQ(message_of(good), "");
  EXPECT_NE(message_of(good + "FRAME\n123").find("frame 1 breaks off after 3 of 6 bytes"), std::string::npos);
  EXPECT_NE(message_of(good + "GRAPE\n123456").find("frame 1: no FRAME"), std::string::npos);
}

TEST(Video, ReportsAFileThatIsNoVideo) {
  EXPECT_THROW(open_video("/nonexistent/video.mkv"), std::runtime_error);
}

}  // namespace
}  // namespace csd::peers
