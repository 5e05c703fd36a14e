// SPDX-License-Identifier: LGPL-2.1-or-later
#include "programs/absent_features.h"

#include <gmock/gmock.h>

namespace csd::programs {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

Feature feature(FeatureId id, FeatureState state = FeatureState::tracked) {
  return {id, 1, 1, state, 1, true};
}

/// For frames numbered from 10, in lines from 2 on.
std::vector<std::string> notes_of(const std::vector<std::vector<Feature>> &frames) {
  score::Recording tracks;
  tracks.file = "f";
  for (std::size_t i = 0; i < frames.size(); ++i) tracks.frames.push_back({true, 10 + i, no_time, 2 + i, frames[i]});
  std::vector<std::string> notes;
  note_absent(tracks, notes);
  return notes;
}

TEST(AbsentFeatures, FeaturesThatBeginLateOrEndAreNotMissed) {
  EXPECT_THAT(notes_of({{feature(1)},
                        {feature(1), feature(2, FeatureState::lost)},
                        {feature(1, FeatureState::ended), feature(2, FeatureState::out)},
                        {feature(2, FeatureState::occluded)}}),
              IsEmpty());
}

TEST(AbsentFeatures, NotesAnAbsenceInTheMiddle) {
  EXPECT_THAT(notes_of({{feature(1), feature(2)}, {feature(2)}, {}, {feature(1), feature(2)}}),
              ElementsAre("f:3: from frame 11 on, 2 features are absent that had not ended, in 2 frames, counted "
                          "as not tracked: is the file whole?"));
}

TEST(AbsentFeatures, AnotherSizeOfThePictureEndsAllFeatures) {
  score::Recording tracks;
  for (int i = 0; i < 4; ++i)
    tracks.frames.push_back(
        {true, static_cast<std::uint64_t>(i), no_time, 0, {feature(i / 2)}, no_time, no_time, i < 2 ? 640 : 320, 480});
  std::vector<std::string> notes;
  note_absent(tracks, notes);
  EXPECT_THAT(notes, IsEmpty());
}

TEST(AbsentFeatures, NotesAnAbsenceFromTheLastFrame) {
  EXPECT_THAT(notes_of({{feature(1), feature(2, FeatureState::lost)}, {feature(1)}}),
              ElementsAre("f:3: from frame 11 on, 1 feature is absent that had not ended, in 1 frame, counted "
                          "as not tracked: is the file whole?"));
}

TEST(AbsentFeatures, AnIdThatBeginsAgainIsAliveAgain) {
  EXPECT_EQ(notes_of({{feature(1, FeatureState::ended)}, {feature(1)}, {}}).size(), 1u);
}

TEST(AbsentFeatures, IgnoresAFrameWithoutMetadata) {
  score::Recording tracks;
  tracks.frames = {{true, 0, 0, 1, {feature(1)}}, {false, 0, 1, 2, {}}, {true, 1, 2, 3, {feature(1)}}};
  std::vector<std::string> notes;
  note_absent(tracks, notes);
  EXPECT_THAT(notes, IsEmpty());
}

}  // namespace
}  // namespace csd::programs
