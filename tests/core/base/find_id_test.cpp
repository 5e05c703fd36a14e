// SPDX-License-Identifier: LGPL-2.1-or-later
#include "base/find_id.h"

#include <gtest/gtest.h>

#include <vector>

namespace csd {
namespace {

TEST(FindId, FindsTheElementWithAnIdAndNoOther) {
  const std::vector<Feature> features{{.id = 2}, {.id = 5}, {.id = 9}};
  for (std::size_t i = 0; i < features.size(); ++i)
    EXPECT_EQ(find_id(features, features[i].id, &Feature::id) - features.begin(), static_cast<std::ptrdiff_t>(i));
  for (const FeatureId absent : {0u, 3u, 8u, 10u})
    EXPECT_EQ(find_id(features, absent, &Feature::id), features.end()) << absent;
}

TEST(FindId, FindsNothingInAnEmptyRange) {
  const std::vector<FeatureId> none;
  EXPECT_EQ(find_id(none, 0, std::identity{}), none.end());
}

TEST(FindId, GivesAMutableElement) {
  std::vector<Feature> features{{.id = 4}};
  find_id(features, 4, [](const Feature &f) { return f.id; })->x = 7;
  EXPECT_EQ(features[0].x, 7);
}

}  // namespace
}  // namespace csd
