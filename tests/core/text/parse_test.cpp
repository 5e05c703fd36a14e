// SPDX-License-Identifier: LGPL-2.1-or-later
#include "text/parse.h"

#include <gtest/gtest.h>

#include <clocale>

namespace csd {
namespace {

TEST(Points, AreReadInOrder) {
  const auto points = parse_points("1,2; +3.25 , -4e1 ;\n5,6;");
  ASSERT_TRUE(points) << points.error;
  EXPECT_EQ(points.value, (std::vector<cv::Point2d>{{1, 2}, {3.25, -40}, {5, 6}}));
  EXPECT_TRUE(parse_points("").value.empty());
  EXPECT_TRUE(is_truth(" truth\n"));
  for (const char *other : {"", "truths", "true", "1,2"}) EXPECT_FALSE(is_truth(other));
}

TEST(Points, UseADecimalPointInAnyLocale) {
  if (!std::setlocale(LC_ALL, "de_DE.UTF-8")) GTEST_SKIP() << "no locale de_DE.UTF-8 here";
  EXPECT_EQ(parse_points("1.5,2").value.at(0), cv::Point2d(1.5, 2));
  std::setlocale(LC_ALL, "C");
}

TEST(Points, ABadPartIsQuoted) {
  EXPECT_NE(parse_points("1,2;\xff,3").error.find("\"?,3\" (point 2) is not x,y"), std::string::npos);
  EXPECT_NE(parse_points("1,2;;3,4").error.find("\"\" (point 2)"), std::string::npos);
  EXPECT_NE(parse_points("1,nan").error.find("is not finite"), std::string::npos);
}

TEST(Region, IsInWholePixels) {
  EXPECT_EQ(parse_region(" 1,2, 3,4 ").value, cv::Rect(1, 2, 3, 4));
  EXPECT_TRUE(parse_region("").value.empty());
  for (const char *bad : {"1,2,3", "1,2,3,4,5", "1.5,2,3,4", "-1,2,3,4", "1,2,0,4", "1,2,3,99999999999", "a,b,c,d"})
    EXPECT_FALSE(parse_region(bad)) << bad;
}

}  // namespace
}  // namespace csd
