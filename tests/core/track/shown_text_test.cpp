// SPDX-License-Identifier: LGPL-2.1-or-later
#include "track/shown_text.h"

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

}  // namespace
}  // namespace csd
