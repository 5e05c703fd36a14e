// SPDX-License-Identifier: LGPL-2.1-or-later
#include "csd/tuning.h"

#include <gtest/gtest.h>

#include <set>
#include <stdexcept>
#include <string>

namespace csd {
namespace {

TEST(Tuning, EachFieldIsSetByItsOwnName) {
  std::set<std::string_view> names;
  for (const auto &field : tuning_fields()) {
    EXPECT_TRUE(names.insert(field.name).second) << field.name;
    Tuning tuning;
    set(tuning, std::string(field.name) + "=-12.5");
    for (const auto &other : tuning_fields())
      EXPECT_EQ(tuning.*other.field, &other == &field ? -12.5 : default_tuning.*other.field) << other.name;
  }
  Tuning tuning;
  set(tuning, "gate_floor=3");
  EXPECT_EQ(tuning.gate_floor, 3);
}

TEST(Tuning, SaysWhatIsWrong) {
  const auto complaint = [](std::string_view assignment) -> std::string {
    Tuning tuning;
    try {
      set(tuning, assignment);
    } catch (const std::invalid_argument &e) {
      return e.what();
    }
    return "none";
  };
  EXPECT_EQ(complaint("gate_floor"), "\"gate_floor\" is not NAME=VALUE");
  EXPECT_EQ(complaint("gate_flour=1"), "no number of csd is called \"gate_flour\"");
  for (const std::string bad : {"", "x", "1x", "nan", "inf", "1e999"})
    EXPECT_EQ(complaint("gate_floor=" + bad), "\"" + bad + "\" is not a number, for gate_floor");
}

TEST(Tuning, CountsAndTimes) {
  EXPECT_EQ(count(5), 5u);
  EXPECT_EQ(nanoseconds(0.5), second / 2);
  EXPECT_EQ(nanoseconds(-1), -second);
}

}  // namespace
}  // namespace csd
