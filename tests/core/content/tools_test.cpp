// SPDX-License-Identifier: LGPL-2.1-or-later
#include "content/tools.h"

#include <gtest/gtest.h>

#include <opencv2/imgproc.hpp>

#include "core/picture.h"
#include "image/work_frame.h"

namespace csd {
namespace {

const cv::Scalar tissue(60, 80, 160);     // B G R, saturation .62
const cv::Scalar pale(165, 175, 200);     // .17
const cv::Scalar steel(120, 118, 112);    // .07
const cv::Rect shaft(300, 200, 340, 60);  // of a tool from the right edge
const cv::Point inside(450, 230), far(100, 400);

cv::Mat scene(cv::Size size = {640, 480}) {
  cv::Mat bgr(480, 640, CV_8UC3, tissue), out;
  bgr(cv::Rect(0, 0, 640, 120)).setTo(pale);
  bgr(shaft).setTo(steel);
  cv::resize(bgr, out, size, 0, 0, cv::INTER_NEAREST);
  return out;
}

cv::Mat tools_of(const cv::Mat &bgr, test::Layout layout = test::Layout::bgr) {
  const auto packed = test::pack(bgr, layout);
  WorkFrame frame;
  frame.load(packed.view);
  cv::Mat mask;
  find_tools(frame, mask);
  EXPECT_EQ(mask.size(), frame.size());
  EXPECT_EQ(mask.type(), CV_8UC1);
  return mask;
}

bool at(const cv::Mat &mask, cv::Point p) {
  return mask.at<std::uint8_t>(p) == 255;
}

TEST(Tools, AreGreyAmongColouredTissue) {
  for (const auto layout : {test::Layout::bgr, test::Layout::i420, test::Layout::v210}) {
    const auto mask = tools_of(scene(), layout);
    EXPECT_TRUE(at(mask, inside));
    EXPECT_FALSE(at(mask, far));
    EXPECT_FALSE(at(mask, {320, 60})) << "pale tissue";
    // The mask has a margin, because a point at a tool's outline sticks to the tool.
    EXPECT_TRUE(at(mask, {450, shaft.y - 8}));
    EXPECT_FALSE(at(mask, {450, shaft.y - 20}));
    EXPECT_FALSE(at(mask, {450, shaft.br().y + 20}));
  }
}

TEST(Tools, AreFoundAtAnyPictureSize) {
  const auto low = tools_of(scene({320, 240}));
  EXPECT_TRUE(at(low, inside / 2));
  EXPECT_FALSE(at(low, far / 2));
  const auto high = tools_of(scene({1920, 1440}));  // 768 × 576
  EXPECT_TRUE(at(high, inside * 1.2));
  EXPECT_FALSE(at(high, far * 1.2));
  EXPECT_EQ(cv::countNonZero(tools_of(cv::Mat(3, 2, CV_8UC3, steel))), 0) << "grey, but no greyer than the rest";
}

TEST(Tools, AreFoundInSmokeThatFadesTheTissuesColour) {
  const cv::Mat smoke(480, 640, CV_8UC3, cv::Scalar(190, 190, 190));
  cv::Mat bgr;
  cv::addWeighted(scene(), 0.25, smoke, 0.75, 0, bgr);  // saturation of tissue .14, of steel .01
  const auto mask = tools_of(bgr);
  EXPECT_TRUE(at(mask, inside));
  EXPECT_FALSE(at(mask, far));
}

TEST(Tools, AGrayPictureHasNone) {
  cv::Mat gray, bgr;
  cv::cvtColor(scene(), gray, cv::COLOR_BGR2GRAY);
  cv::cvtColor(gray, bgr, cv::COLOR_GRAY2BGR);
  EXPECT_EQ(cv::countNonZero(tools_of(bgr)), 0);
  EXPECT_EQ(cv::countNonZero(tools_of(cv::Mat(480, 640, CV_8UC3, cv::Scalar(8, 9, 8)))), 0) << "darkness";
}

}  // namespace
}  // namespace csd
