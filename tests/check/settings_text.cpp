// SPDX-License-Identifier: LGPL-2.1-or-later
#include <gtest/gtest.h>

#include <clocale>

#include "latency.h"
#include "message.h"
#include "parse.h"

namespace {

TEST(Points, AreReadInOrder) {
  const auto points = csd::parse_points("1,2; +3.25 , -4e1 ;\n5,6;");
  ASSERT_TRUE(points) << points.error;
  EXPECT_EQ(points.value, (std::vector<cv::Point2d>{{1, 2}, {3.25, -40}, {5, 6}}));
  EXPECT_TRUE(csd::parse_points("").value.empty());
  EXPECT_TRUE(csd::is_truth(" truth\n"));
  for (const char *other : {"", "truths", "true", "1,2"}) EXPECT_FALSE(csd::is_truth(other));
}

TEST(Points, DecimalPointWhateverTheLocale) {
  if (!std::setlocale(LC_ALL, "de_DE.UTF-8")) GTEST_SKIP() << "no locale de_DE.UTF-8 here";
  EXPECT_EQ(csd::parse_points("1.5,2").value.at(0), cv::Point2d(1.5, 2));
  std::setlocale(LC_ALL, "C");
}

TEST(Points, BadPartIsShown) {
  EXPECT_NE(csd::parse_points("1,2;\xff,3").error.find("\"?,3\" (point 2) is not x,y"), std::string::npos);
  EXPECT_NE(csd::parse_points("1,2;;3,4").error.find("\"\" (point 2)"), std::string::npos);
  EXPECT_NE(csd::parse_points("1,nan").error.find("is not finite"), std::string::npos);
}

TEST(Region, WholePixels) {
  EXPECT_EQ(csd::parse_region(" 1,2, 3,4 ").value, cv::Rect(1, 2, 3, 4));
  EXPECT_TRUE(csd::parse_region("").value.empty());
  for (const char *bad : {"1,2,3", "1,2,3,4,5", "1.5,2,3,4", "-1,2,3,4", "1,2,0,4", "1,2,3,99999999999", "a,b,c,d"})
    EXPECT_FALSE(csd::parse_region(bad)) << bad;
}

TEST(Latency, PercentileIsAtMostASixteenthTooHigh) {
  csd::Latency latency;
  EXPECT_EQ(latency.quantile(0.5), 0u);
  for (std::uint64_t ns = 1; ns <= 100000; ++ns) latency.add(ns);
  for (const auto &[q, exact] : {std::pair{0.5, 50000.}, {0.95, 95000.}, {0.0001, 10.}}) {
    EXPECT_GE(static_cast<double>(latency.quantile(q)), exact);
    EXPECT_LE(static_cast<double>(latency.quantile(q)), exact * (1 + 1 / 16.) + 1);
  }
  EXPECT_EQ(latency.quantile(1), 100000u);
  EXPECT_EQ(latency.max(), 100000u);
  latency.add(~std::uint64_t{0});
  EXPECT_EQ(latency.quantile(1), ~std::uint64_t{0});
}

TEST(MessageGate, AChangeInTheIntervalIsPostedAtItsEnd) {
  csd::MessageGate gate;
  const auto change = GST_CSD_TRACK_POST_MESSAGES_CHANGE;
  EXPECT_TRUE(gate.due(change, 100, true, 0));
  EXPECT_FALSE(gate.due(change, 100, true, 40));
  EXPECT_FALSE(gate.due(change, 100, false, 80));
  EXPECT_TRUE(gate.due(change, 100, false, 120));
  EXPECT_FALSE(gate.due(change, 100, false, 300));
  EXPECT_TRUE(gate.due(change, 100, true, 10)) << "time went back";
  EXPECT_TRUE(gate.due(change, 100, true, GST_CLOCK_TIME_NONE));
  EXPECT_FALSE(gate.due(GST_CSD_TRACK_POST_MESSAGES_NONE, 0, true, 900));
  EXPECT_FALSE(gate.due(change, 0, false, 901)) << "what came while nobody listened is gone";
}

}  // namespace
