// SPDX-License-Identifier: LGPL-2.1-or-later
#include "programs/json_writer.h"

#include <gtest/gtest.h>

#include <limits>

namespace csd::programs {
namespace {

TEST(JsonWriter, EachMemberAndElementHasALine) {
  JsonWriter out;
  out.begin_object().key("a").whole(18446744073709551615u).key("b").begin_array().end_array().key("c").begin_array();
  out.begin_object().end_object().values(std::vector<double>{1.5}).text("d").end_array().end_object();
  EXPECT_EQ(out.finish(), R"({
 "a": 18446744073709551615,
 "b": [],
 "c": [
  {},
  [
   1.5
  ],
  "d"
 ]
}
)");
}

TEST(JsonWriter, NumbersAreReadAsWhatTheyWere) {
  const auto written = [](double number) { return JsonWriter().value(number).finish(); };
  EXPECT_EQ(written(0.1), "0.1\n");
  EXPECT_EQ(written(-3), "-3.0\n");
  EXPECT_EQ(written(1e300), "1e+300\n");
  EXPECT_EQ(written(1.0 / 3), "0.3333333333333333\n");
  EXPECT_EQ(written(std::numeric_limits<double>::quiet_NaN()), "null\n");
  EXPECT_EQ(written(-std::numeric_limits<double>::infinity()), "null\n");
}

TEST(JsonWriter, TextIsUtf8) {
  const auto written = [](std::string_view text) { return JsonWriter().text(text).finish(); };
  EXPECT_EQ(written("größe 追跡 😀"), "\"größe 追跡 😀\"\n");
  EXPECT_EQ(written("\"\\\n"), "\"\\\"\\\\\\u000a\"\n");
  EXPECT_EQ(written("gr\xf6\xdf"
                    "e"),
            "\"gr\ufffd\ufffde\"\n")
      << "Latin-1";
  EXPECT_EQ(written("a\xe8\xbf"), "\"a\ufffd\ufffd\"\n") << "torn";
  EXPECT_EQ(written("\xc0\xaf"), "\"\ufffd\ufffd\"\n") << "too long";
}

}  // namespace
}  // namespace csd::programs
