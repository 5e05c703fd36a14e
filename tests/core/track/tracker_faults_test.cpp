// SPDX-License-Identifier: LGPL-2.1-or-later
// Failures in the middle of a frame, mostly for lack of memory: nothing is lost, and nothing happens twice.
#include <gtest/gtest.h>

#include "track/scripted_algorithm.h"
#include "track/tracker.h"

namespace csd {
namespace {

class TrackerFaults : public TrackerLife {};

TEST_F(TrackerFaults, AfterAnExceptionTheTrackerGoesOnBlind) {
  Tracker tracker(with_points({{10, 20}, {400, 20}}), std::make_unique<Scripted>());
  next(tracker);
  script_.throws = true;
  EXPECT_THROW(next(tracker), std::runtime_error);
  const auto &tracks = tracker.process_blind(320, 240, pts_);
  ASSERT_EQ(tracks.features.size(), 2u);
  EXPECT_EQ(tracks.frame, 1u);
  EXPECT_EQ(tracks.features[0].state, FeatureState::lost);
  EXPECT_EQ(tracks.features[1].state, FeatureState::out);
}

TEST_F(TrackerFaults, AFailedFrameProcessedBlindIsOneFrame) {
  for (const std::int64_t frame : {second / 25, no_time}) {  // with timestamps and without
    Tracker tracker(with_points({{100, 100}}), std::make_unique<Scripted>());
    const auto stamp = [frame](int i) { return frame == no_time ? no_time : i * frame; };
    const auto view = MovingScene::gray_view(texture_);
    tracker.process(view, stamp(0));
    script_.throws = true;
    for (int i = 1; i <= 3; ++i) {
      EXPECT_THROW(tracker.process(view, stamp(i)), std::runtime_error);
      EXPECT_EQ(tracker.process_blind(320, 240, stamp(i)).frame, static_cast<std::uint64_t>(i));
    }
    tracker.process_blind(320, 240, stamp(4));  // a frame without pixels
    script_.throws = false;
    EXPECT_EQ(tracker.process(view, stamp(5)).frame, 5u);
    EXPECT_EQ(script_.time, 5 * second / 25) << frame;
    EXPECT_EQ(tracker.stats().frames, 6u);
  }
}

TEST_F(TrackerFaults, RequestsToAFailingFrameAreAnsweredOnce) {
  Tracker tracker(with_points({{10, 20}, {30, 40}}), std::make_unique<Scripted>());
  next(tracker);
  const auto kept = tracker.add_point(12, 13), gone = tracker.add_point(14, 15);
  EXPECT_TRUE(tracker.remove_point(1));
  script_.tracking = [&] { EXPECT_TRUE(tracker.remove_point(gone)); };
  script_.throws = true;
  EXPECT_THROW(next(tracker), std::runtime_error);
  EXPECT_TRUE(tracker.remove_point(0)) << "also after it";
  const auto &tracks = tracker.process_blind(320, 240, pts_);
  EXPECT_EQ(ids(tracks), (std::vector<FeatureId>{0, 1, kept}));
  EXPECT_EQ(find(tracks, 0)->state, FeatureState::ended);
  EXPECT_EQ(find(tracks, 1)->state, FeatureState::ended);
  EXPECT_EQ(find(tracks, kept)->state, FeatureState::lost);
  script_.throws = false;
  script_.tracking = nullptr;
  EXPECT_EQ(ids(next(tracker)), (std::vector<FeatureId>{kept}));
  EXPECT_EQ(find(tracks, kept)->state, FeatureState::learning);
  EXPECT_EQ(script_.begun, (std::vector<FeatureId>{0, 1, kept}));
}

// Memory may run out between two points. Those that have begun must not begin again, and the others must not be lost.
TEST_F(TrackerFaults, PointsThatTheAlgorithmFailsToBeginAreLostAndBeginLater) {
  Tracker tracker(with_points({{10, 20}, {30, 40}, {50, 60}}), std::make_unique<Scripted>());
  const auto asked = tracker.add_point(12, 13), last = tracker.add_point(14, 15);
  script_.cannot_begin = 1;
  EXPECT_THROW(next(tracker), std::runtime_error);
  const auto &tracks = tracker.process_blind(320, 240, pts_);
  EXPECT_EQ(ids(tracks), (std::vector<FeatureId>{0, 1, 2, asked, last}));
  for (const auto &f : tracks.features) EXPECT_EQ(f.state, FeatureState::lost) << f.id;
  script_.cannot_begin = asked;
  EXPECT_THROW(next(tracker), std::runtime_error);
  script_.cannot_begin = no_feature;
  next(tracker);
  EXPECT_EQ(ids(tracks), (std::vector<FeatureId>{0, 1, 2, asked, last}));
  EXPECT_EQ(find(tracks, last)->state, FeatureState::learning);
  EXPECT_EQ(find(tracks, last)->x, 14);
  EXPECT_EQ(script_.begun, (std::vector<FeatureId>{0, 1, 2, asked, last}));
}

// Postponed ids may be entered after later ones. The algorithm must still get ascending ids, whether or not there is a
// report between the frames (TrackerLife's track() checks it).
TEST_F(TrackerFaults, ClaimsHaveAscendingIdsAfterAFault) {
  for (const bool told : {false, true}) {
    script_.begun.clear();
    Tracker tracker(with_points({{10, 20}}), std::make_unique<Scripted>());
    next(tracker);
    tracker.reset();
    tracker.add_point(12, 13);
    tracker.add_point(14, 15);
    script_.cannot_begin = 2;
    EXPECT_THROW(next(tracker), std::runtime_error);
    script_.cannot_begin = no_feature;
    if (told) tracker.process_blind(320, 240, pts_);
    const auto &tracks = next(tracker);
    for (const FeatureId id : {1u, 2u, 3u}) EXPECT_NE(find(tracks, id)->state, FeatureState::lost) << id;
    EXPECT_EQ(script_.begun, (std::vector<FeatureId>{0, 1, 2, 3}));
  }
}

TEST_F(TrackerFaults, ADetectedPointThatFailsToBeginIsDropped) {
  Settings settings;
  settings.max_features = 6;
  Tracker tracker(settings, std::make_unique<Scripted>());
  script_.cannot_begin = 2;
  EXPECT_THROW(next(tracker), std::runtime_error);
  EXPECT_EQ(ids(tracker.process_blind(320, 240, pts_)), (std::vector<FeatureId>{0, 1}));
  for (int i = 0; i < 50; ++i) next(tracker);
  const auto &tracks = next(tracker);
  EXPECT_EQ(ids(tracks), (std::vector<FeatureId>{0, 1, 3, 4, 5, 6}));
  for (const auto &f : tracks.features) EXPECT_EQ(f.state, FeatureState::tracked) << f.id;
}

// The positions are those of the tracked frame, so the algorithm must keep that frame's pixels.
TEST_F(TrackerFaults, ATrackedFrameIsFinishedDespiteAFault) {
  Tracker tracker(with_points({{10, 20}}), std::make_unique<Scripted>());
  script_.cannot_begin = 0;
  EXPECT_THROW(next(tracker), std::runtime_error);
  EXPECT_EQ(script_.finished, 1);
  script_.throws = true;
  EXPECT_THROW(next(tracker), std::runtime_error);
  EXPECT_EQ(script_.finished, 1) << "not tracked";
}

TEST_F(TrackerFaults, ARemovalIsKeptUntilItIsDone) {
  Tracker tracker(with_points({{10, 20}, {30, 40}}), std::make_unique<Scripted>());
  next(tracker);
  EXPECT_TRUE(tracker.remove_point(0));
  EXPECT_TRUE(tracker.remove_point(1));
  script_.cannot_end = 1;
  EXPECT_THROW(next(tracker), std::runtime_error);
  script_.cannot_end = no_feature;
  for (const auto &f : next(tracker).features) EXPECT_EQ(f.state, FeatureState::ended) << f.id;
  EXPECT_EQ(script_.ended, (std::vector<FeatureId>{0, 1}));
}

TEST_F(TrackerFaults, AResetIsKeptUntilItIsDone) {
  Tracker tracker(with_points({{10, 20}}), std::make_unique<Scripted>());
  next(tracker);
  tracker.reset();
  script_.cannot_forget = true;
  EXPECT_THROW(next(tracker), std::runtime_error);
  script_.cannot_forget = false;
  const int forgotten = script_.forgotten;
  const auto &tracks = next(tracker);
  EXPECT_EQ(script_.forgotten, forgotten + 1);
  EXPECT_EQ(ids(tracks), (std::vector<FeatureId>{0, 1}));
  EXPECT_EQ(tracks.features[0].state, FeatureState::ended);
}

}  // namespace
}  // namespace csd
