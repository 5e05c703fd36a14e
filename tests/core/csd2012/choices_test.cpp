// SPDX-License-Identifier: LGPL-2.1-or-later
#include "csd2012/choices.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <stdexcept>
#include <string>
#include <vector>

#include "csd2012/easy_scene.h"

namespace csd::csd2012 {
namespace {

TEST(Choices, EachFieldIsSetByItsOwnName) {
  std::set<std::string_view> names;
  constexpr Choices usual;
  for (const auto &field : choice_fields()) {
    EXPECT_TRUE(names.insert(field.name).second) << field.name;
    Choices choices;
    set(choices, std::string(field.name) + "=-12.5");
    for (const auto &other : choice_fields())
      EXPECT_EQ(choices.*other.field, &other == &field ? -12.5 : usual.*other.field) << other.name;
  }
}

TEST(Choices, SayWhoseNumberIsMissing) {
  Choices choices;
  try {
    set(choices, "gate_floor=1");
    ADD_FAILURE() << "gate_floor is csd's";
  } catch (const std::invalid_argument &e) {
    EXPECT_STREQ(e.what(), "no number of csd-2012 is called \"gate_floor\"");
  }
}

// Other smoke, other tests in the nodes or another colour space make other descriptors, and these find other places.
TEST(Choices, OfSmokeSearchAndColourMakeOtherDescriptors) {
  auto settings = few_features();
  settings.max_features = 6;
  std::vector<std::vector<Tracks>> found{run(settings, 2, 20)};
  for (const auto *assignment : {"smoke_as_printed=1", "exhaustive=1", "colour=1", "colour=0"}) {
    Choices choices;
    set(choices, assignment);
    const auto tracks = run(settings, 2, 20, choices);
    for (const auto &others : found) EXPECT_FALSE(same_tracks(others, tracks)) << assignment;
    // In any case descriptors take over from LK, and see most of the easy scene.
    EXPECT_GE(std::count_if(tracks.back().features.begin(), tracks.back().features.end(),
                            [](const Feature &f) { return f.state == FeatureState::tracked; }),
              4)
        << assignment;
    found.push_back(tracks);
  }
}

/// How far claims are off in the mean, px.
double error_of(const std::vector<Tracks> &all) {
  double sum = 0;
  int claims = 0;
  for (std::size_t i = 9; i < all.size(); ++i)
    for (const auto &f : all[i].features) {
      if (f.state != FeatureState::tracked) continue;
      const auto &start = all[0].features[f.id];
      const auto at = sway(static_cast<int>(i)) - sway(0);
      sum += std::hypot(f.x - start.x - at.x, f.y - start.y - at.y);
      ++claims;
    }
  return sum / claims;
}

// Pixels that noise moves less, and the middle of a cluster instead of one patch of it.
TEST(Choices, SmoothedAndByItsClusterAFeatureIsFoundMoreExactly) {
  Choices choices;
  choices.cluster_radius = choices.smoothing = 0;
  const double usual = error_of(run(few_features(), 2, 40, choices));
  choices.cluster_radius = 2;
  EXPECT_LT(error_of(run(few_features(), 2, 40, choices)), usual);
  choices.smoothing = 2;
  EXPECT_LT(error_of(run(few_features(), 2, 40, choices)), usual);
}

// Five trees say another place than one; the patch, where it fits, says it to a fraction of a pixel.
TEST(Choices, OfTheForestSeveralTreesAndTheAlignedPatchBothTell) {
  auto settings = few_features();
  settings.max_features = 6;
  Choices alone = forest_choices();
  alone.co_training = 0;
  auto one = alone;
  one.trees = 1;
  const auto five_trees = run(settings, 2, 30, alone), one_tree = run(settings, 2, 30, one);
  EXPECT_FALSE(same_tracks(five_trees, one_tree));
  const double together = error_of(run(settings, 2, 30, forest_choices()));
  EXPECT_LT(together, 0.5 * error_of(five_trees));
  EXPECT_LT(together, 0.2);
}

// The patch is aligned where the feature was last, too: also in the frame in which the descriptor takes over, and where
// that never finds anything.
TEST(Choices, OfTheForestThePatchGoesOnAloneWhereTheTreesFindNothing) {
  auto settings = few_features();
  settings.max_features = 4;
  auto choices = forest_choices();
  choices.min_probability = 1e3;
  const auto all = run(settings, 2, 30, choices);
  ASSERT_EQ(all.back().features.size(), 4u);
  for (const auto &f : all.back().features) EXPECT_EQ(f.state, FeatureState::tracked) << f.id;
}

// With sync learning no thread decides anything, however many trees there are.
TEST(Choices, OfTheForestGiveTheSameForEveryNumberOfThreads) {
  auto settings = few_features();
  settings.max_features = 4;
  EXPECT_TRUE(same_tracks(run(settings, 1, 20, forest_choices()), run(settings, 3, 20, forest_choices())));
}

// Where less than the least probability is found, nothing is claimed.
TEST(Choices, WithMoreThanAnyProbabilityNothingIsClaimedOnceTheDescriptorHasTakenOver) {
  auto settings = few_features();
  settings.max_features = 3;
  Choices choices;
  choices.min_probability = 1e3;
  const auto all = run(settings, 2, 30, choices);
  ASSERT_EQ(all.back().features.size(), 3u);
  EXPECT_TRUE(std::none_of(all.back().features.begin(), all.back().features.end(),
                           [](const Feature &f) { return claims_position(f.state); }));
}

}  // namespace
}  // namespace csd::csd2012
