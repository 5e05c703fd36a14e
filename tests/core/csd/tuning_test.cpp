// SPDX-License-Identifier: LGPL-2.1-or-later
#include "csd/tuning.h"

#include <gtest/gtest.h>

#include <set>
#include <string>

namespace csd {
namespace {

TEST(Tuning, SetsEachFieldByItsName) {
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

TEST(Tuning, ConvertsCountsAndTimes) {
  EXPECT_EQ(count(5), 5u);
  EXPECT_EQ(nanoseconds(0.5), second / 2);
  EXPECT_EQ(nanoseconds(-1), -second);
}

}  // namespace
}  // namespace csd
