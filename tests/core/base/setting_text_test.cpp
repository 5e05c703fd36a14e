// SPDX-License-Identifier: LGPL-2.1-or-later
#include "base/setting_text.h"

#include <gtest/gtest.h>

namespace csd {
namespace {

TEST(ShownText, IsShortAndPrintable) {
  EXPECT_EQ(shown_text(""), "\"\"");
  EXPECT_EQ(shown_text("a b~"), "\"a b~\"");
  EXPECT_EQ(shown_text("\xffx\n\x7f"), "\"?x??\"");
  EXPECT_EQ(shown_text(std::string(40, 'x')), "\"" + std::string(40, 'x') + "\"");
  EXPECT_EQ(shown_text(std::string(41, 'x')), "\"" + std::string(40, 'x') + "…\"");
}

TEST(Trimmed, RemovesBlanksOnBothSides) {
  EXPECT_EQ(trimmed(" \t a b\r\n"), "a b");
  EXPECT_EQ(trimmed("a"), "a");
  EXPECT_EQ(trimmed(" \n"), "");
  EXPECT_EQ(trimmed(""), "");
}

}  // namespace
}  // namespace csd
