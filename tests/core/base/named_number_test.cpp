// SPDX-License-Identifier: LGPL-2.1-or-later
#include "base/named_number.h"

#include <gtest/gtest.h>

#include <stdexcept>
#include <string>

namespace csd {
namespace {

struct Numbers {
  double near = 1, far = 2;
};
constexpr NamedNumber<Numbers> fields[] = {{"near", &Numbers::near}, {"far", &Numbers::far}};

void set(Numbers &numbers, std::string_view assignment) {
  set_number(numbers, std::span<const NamedNumber<Numbers>>(fields), assignment, "the test");
}

TEST(NamedNumber, SetsTheNamedFieldAndNoOther) {
  Numbers numbers;
  set(numbers, "far=-3.5e1");
  EXPECT_EQ(numbers.near, 1);
  EXPECT_EQ(numbers.far, -35);
}

TEST(NamedNumber, DescribesTheError) {
  const auto complaint = [](std::string_view assignment) -> std::string {
    Numbers numbers;
    try {
      set(numbers, assignment);
    } catch (const std::invalid_argument &e) {
      return e.what();
    }
    return "none";
  };
  EXPECT_EQ(complaint("near"), "\"near\" is not NAME=VALUE");
  EXPECT_EQ(complaint("nearer=1"), "no number of the test is called \"nearer\"");
  for (const std::string bad : {"", "x", "1x", "nan", "inf", "1e999"})
    EXPECT_EQ(complaint("near=" + bad), "\"" + bad + "\" is not a number, for near");
}

}  // namespace
}  // namespace csd
