// SPDX-License-Identifier: LGPL-2.1-or-later
#include "score/palindrome.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <optional>

namespace csd::score {
namespace {

using testing::HasSubstr;

constexpr std::nullopt_t none = std::nullopt;
using Path = std::vector<std::optional<double>>;  ///< x by frame; none: lost

/// Features 0, 1, … at y = 50.
Recording tracks_of(const std::vector<Path> &paths, int height = 480) {
  Recording tracks;
  tracks.file = "tracks.jsonl";
  tracks.width = 640;
  tracks.height = height;
  for (std::size_t i = 0; i < paths.front().size(); ++i) {
    TrackFrame frame;
    frame.frame = i;
    frame.line = i + 1;
    for (std::size_t id = 0; id < paths.size(); ++id) {
      const auto &x = paths[id][i];
      frame.features.push_back({static_cast<FeatureId>(id), x.value_or(0), 50,
                                x ? FeatureState::tracked : FeatureState::lost, x ? 1. : 0., true});
    }
    tracks.frames.push_back(frame);
  }
  return tracks;
}

std::string error_of(const Recording &tracks) {
  try {
    score_palindrome(tracks);
  } catch (const InputError &error) {
    return error.what();
  }
  return "no error";
}

TEST(Palindrome, IsAsComputedByHandAtOddLength) {
  // Images 0 1 2 1 0. Of feature 0: 10 and 12 (returned), 20 and 25 (not apart), 30. Of feature 1: 10 and 15.1 (falsely
  // returned, apart), 20 and nothing, nothing.
  const PalindromeScore score = score_palindrome(tracks_of({{10, 20, 30, 25, 12}, {10, 20, none, none, 15.1}}));
  EXPECT_EQ(score.frames, 5u);
  EXPECT_EQ(score.features, 2u);
  EXPECT_EQ(score.claims, 5u + 3u);
  EXPECT_EQ(score.pairs, 2u + 1u);
  EXPECT_EQ(score.apart, 1u);
  EXPECT_EQ(score.returned, 1u);
  EXPECT_EQ(score.falsely_returned, 1u);
  EXPECT_DOUBLE_EQ(score.claimed_share(), .8);
  EXPECT_DOUBLE_EQ(score.apart_share(), 1. / 3);
  EXPECT_DOUBLE_EQ(score.returned_share(), .5);
  EXPECT_DOUBLE_EQ(score.falsely_returned_share(), .5);
}

TEST(Palindrome, EvenLengthShowsTheLastImageTwice) {
  // Images 0 1 1 0. Both pairs count: 20 and 26 are apart, 10 and 13 neither returned nor falsely returned.
  const PalindromeScore score = score_palindrome(tracks_of({{10, 20, 26, 13}}));
  EXPECT_EQ(score.claims, 4u);
  EXPECT_EQ(score.pairs, 2u);
  EXPECT_EQ(score.apart, 1u);
  EXPECT_EQ(score.returned, 0u);
  EXPECT_EQ(score.falsely_returned, 0u);
}

TEST(Palindrome, ThresholdsGrowAbove576Lines) {
  // 1152 lines: 4 and 10 px, both still near enough.
  const PalindromeScore score = score_palindrome(tracks_of({{10, 20, 14}, {10, 20, 20}, {10, 20, 20.5}}, 1152));
  EXPECT_EQ(score.returned, 1u);
  EXPECT_EQ(score.falsely_returned, 1u);
  EXPECT_EQ(score.apart, 1u);
}

TEST(Palindrome, AStillTrackerReturnsAndAgrees) {
  const PalindromeScore score = score_palindrome(tracks_of({Path(41, 7.), Path(41, 300.)}));
  EXPECT_EQ(score.returned_share(), 1);
  EXPECT_EQ(score.falsely_returned_share(), 0);
  EXPECT_EQ(score.claimed_share(), 1);
  EXPECT_EQ(score.apart_share(), 0);
}

TEST(Palindrome, WithoutRecoveriesNothingIsCompared) {
  const PalindromeScore score = score_palindrome(tracks_of({{10, none, none}}));
  EXPECT_TRUE(std::isnan(score.apart_share()));
  EXPECT_EQ(score.returned_share(), 0);
  EXPECT_EQ(score.falsely_returned_share(), 0);
  EXPECT_DOUBLE_EQ(score.claimed_share(), 1. / 3);
}

TEST(Palindrome, AFeatureMissingInAFrameIsNotClaimed) {
  Recording tracks = tracks_of({{10, 20, 10}});
  tracks.frames.back().features.clear();
  EXPECT_EQ(score_palindrome(tracks).claims, 2u);
  EXPECT_EQ(score_palindrome(tracks).pairs, 0u);
}

TEST(Palindrome, OnlyTheFirstFramesClaimsCount) {
  const PalindromeScore score = score_palindrome(tracks_of({{10, 20, 10}, {none, 20, 20}}));
  EXPECT_EQ(score.features, 1u);
  EXPECT_EQ(score.claims, 3u);
  EXPECT_EQ(score.returned, 1u);
}

TEST(Palindrome, RefusesTracksThatAreNoPalindrome) {
  EXPECT_EQ(error_of(tracks_of({{10, 20}})), "tracks.jsonl: has 2 frames; a palindrome has 3 or more");
  EXPECT_EQ(error_of(tracks_of({{none, 20, 10}})), "tracks.jsonl:1: claims nothing in its first frame");
  EXPECT_EQ(error_of(tracks_of({{10, 20, 10}}, 0)), "tracks.jsonl: doesn't say the picture's height");
  Recording tracks = tracks_of({{10, 20, 30, 20, 10}});
  tracks.frames.erase(tracks.frames.begin() + 2);
  EXPECT_EQ(error_of(tracks), "tracks.jsonl:4: is frame 3, not 2");
  tracks = tracks_of({{10, 20, 10}});
  tracks.frames[1].numbered = false;
  EXPECT_EQ(error_of(tracks), "tracks.jsonl:2: has no `frame`");
  tracks = tracks_of({{10, 20, 10}});
  tracks.sparse = true;
  EXPECT_THAT(error_of(tracks), HasSubstr("doesn't say how many frames"));
}

}  // namespace
}  // namespace csd::score
