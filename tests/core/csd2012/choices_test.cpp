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

TEST(Choices, SetsEachFieldByItsName) {
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

TEST(Choices, NamesAnUnknownField) {
  Choices choices;
  try {
    set(choices, "gate_floor=1");
    ADD_FAILURE() << "gate_floor belongs to csd";
  } catch (const std::invalid_argument &e) {
    EXPECT_STREQ(e.what(), "no number of csd-2012 is called \"gate_floor\"");
  }
}

// Different smoke, node tests or colour space make different descriptors, which find different places.
TEST(Choices, SmokeSearchAndColourChangeTheDescriptors) {
  auto settings = few_features();
  settings.max_features = 6;
  std::vector<std::vector<Tracks>> found{run(settings, 2, 20)};
  for (const auto *assignment : {"smoke_as_printed=1", "exhaustive=1", "colour=1", "colour=0"}) {
    Choices choices;
    set(choices, assignment);
    const auto tracks = run(settings, 2, 20, choices);
    for (const auto &others : found) EXPECT_FALSE(same_tracks(others, tracks)) << assignment;
    // With every choice, descriptors take over from LK and see most of the easy scene.
    EXPECT_GE(std::count_if(tracks.back().features.begin(), tracks.back().features.end(),
                            [](const Feature &f) { return f.state == FeatureState::tracked; }),
              4)
        << assignment;
    found.push_back(tracks);
  }
}

/// The claims' mean error, px.
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

// Smoothed pixels vary less with noise, and a cluster's middle varies less than any one of its patches.
TEST(Choices, SmoothingAndClustersFindAFeatureMoreExactly) {
  Choices choices;
  choices.cluster_radius = choices.smoothing = 0;
  const double usual = error_of(run(few_features(), 2, 40, choices));
  choices.cluster_radius = 2;
  EXPECT_LT(error_of(run(few_features(), 2, 40, choices)), usual);
  choices.smoothing = 2;
  EXPECT_LT(error_of(run(few_features(), 2, 40, choices)), usual);
}

// Five trees vote for another place than one does. The aligned patch, where it fits, adds a fraction of a pixel.
TEST(Choices, SeveralTreesAndTheAlignedPatchBothChangeThePlace) {
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

// The patch is also aligned at the feature's last place: in the frame in which the descriptor takes over, too, and
// where the descriptor finds nothing.
TEST(Choices, ThePatchGoesOnAloneWhereTheTreesFindNothing) {
  auto settings = few_features();
  settings.max_features = 4;
  auto choices = forest_choices();
  choices.min_probability = 1e3;
  const auto all = run(settings, 2, 30, choices);
  ASSERT_EQ(all.back().features.size(), 4u);
  for (const auto &f : all.back().features) EXPECT_EQ(f.state, FeatureState::tracked) << f.id;
}

// With sync learning, tracks don't depend on the number of threads, however many trees there are.
TEST(Choices, ForestsTrackTheSameForAnyNumberOfThreads) {
  auto settings = few_features();
  settings.max_features = 4;
  EXPECT_TRUE(same_tracks(run(settings, 1, 20, forest_choices()), run(settings, 3, 20, forest_choices())));
}

// A match below the least probability is not claimed.
TEST(Choices, AnUnreachableLeastProbabilityClaimsNothingAfterTheHandover) {
  auto settings = few_features();
  settings.max_features = 3;
  Choices choices;
  choices.min_probability = 1e3;  // holds for a feature that is hidden, too
  const auto all = run(settings, 2, 30, choices);
  ASSERT_EQ(all.back().features.size(), 3u);
  EXPECT_TRUE(std::none_of(all.back().features.begin(), all.back().features.end(),
                           [](const Feature &f) { return claims_position(f.state); }));
}

/// How many of 20 frames before, and of 20 after the scene was hidden, claim the feature.
std::pair<int, int> claims_around_hiding(const Choices &choices) {
  auto settings = few_features();
  settings.points = {{160, 120}};
  const MovingScene scene;
  ThreadPool pool(1);
  Tracker tracker(settings, std::make_unique<Csd2012>(settings, pool, choices));
  int before = 0, after = 0;
  for (int i = 0; i < 60; ++i) {
    auto picture = scene.render({0, 0});
    // A ramp: no order of pixels that the tree has learnt.
    if (i >= 35 && i < 40)
      for (int x = 0; x < picture.cols; ++x) picture.col(x).setTo(cv::Scalar::all(40 + x / 2));
    const auto state = tracker.process(MovingScene::view(picture), i * frame_time).features.at(0).state;
    before += i >= 15 && i < 35 && claims_position(state);
    after += i >= 40 && claims_position(state);
  }
  return {before, after};
}

// A hidden feature needs more to be found again than one in sight needs to be followed.
TEST(Choices, AHiddenFeatureNeedsMoreToBeFoundAgain) {
  Choices choices;
  EXPECT_EQ(claims_around_hiding(choices), std::pair(20, 20));
  choices.refind_probability = 1e3;
  EXPECT_EQ(claims_around_hiding(choices), std::pair(20, 0));
}

// Without a likeness to what the tree has learnt, no leaf counts.
TEST(Choices, AnUnreachableLikenessClaimsNothingAfterTheHandover) {
  Choices choices;
  choices.likeness_power = 1e9;
  choices.min_probability = 1e-6;
  EXPECT_EQ(claims_around_hiding(choices).second, 0);
}

}  // namespace
}  // namespace csd::csd2012
