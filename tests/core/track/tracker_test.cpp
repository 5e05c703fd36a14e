// SPDX-License-Identifier: LGPL-2.1-or-later
// The life of features, with a scripted algorithm.
#include "track/tracker.h"

#include <gtest/gtest.h>

#include <atomic>
#include <cmath>
#include <limits>
#include <opencv2/imgproc.hpp>
#include <thread>

#include "track/moving_scene.h"
#include "track/scripted_algorithm.h"

namespace csd {
namespace {

TEST_F(TrackerLife, GivenPointsHaveIdsInOrderAndAPointOutsideIsOut) {
  Tracker tracker(with_points({{10, 20}, {400, 20}, {30.25, 40.5}}), std::make_unique<Scripted>());
  const auto &tracks = next(tracker);
  ASSERT_EQ(tracks.features.size(), 3u);
  EXPECT_TRUE(tracks.changed);
  EXPECT_EQ(tracks.features[0].state, FeatureState::learning);
  EXPECT_EQ(tracks.features[1].state, FeatureState::out);
  EXPECT_EQ(tracks.features[1].x, 400);
  EXPECT_EQ(tracks.features[1].confidence, 0);
  EXPECT_EQ(tracks.features[2].x, 30.25);
  EXPECT_EQ(script_.begun, (std::vector<FeatureId>{0, 2}));
  script_.kinds[1] = Claim::Kind::lost;  // it never began, so nothing can track it
  next(tracker);
  EXPECT_EQ(find(tracks, 1)->state, FeatureState::out);
  EXPECT_EQ(tracks.frame, 1u);
  EXPECT_EQ(tracker.remove_nearest(390, 20), 2u) << "1 is outside";
}

TEST_F(TrackerLife, AWaitingFeatureIsNotFreshButCounted) {
  Tracker tracker(with_points({{10, 20}, {30, 40}, {50, 60}}), std::make_unique<Scripted>());
  next(tracker);
  script_.waiting = {0, 2};
  for (const auto &f : next(tracker).features) EXPECT_EQ(f.fresh, f.id == 1);
  script_.waiting = {1};
  EXPECT_FALSE(next(tracker).changed);
  EXPECT_EQ(tracker.stats().waited, 3u);
  script_.waiting = {};
  for (const auto &f : next(tracker).features) EXPECT_TRUE(f.fresh);
  EXPECT_EQ(tracker.stats().waited, 3u);
}

TEST_F(TrackerLife, AJumpIsReportedUntilAFrameIsTracked) {
  Tracker tracker(with_points({{10, 20}}), std::make_unique<Scripted>());
  const auto view = MovingScene::gray_view(texture_);
  constexpr auto frame = second / 25;
  tracker.process(view, 0, frame, true);
  EXPECT_FALSE(script_.jumped) << "the first frame is no jump";
  tracker.process(view, frame, frame);
  EXPECT_FALSE(script_.jumped);
  tracker.process(view, 2 * frame, frame, true);
  EXPECT_TRUE(script_.jumped);
  tracker.process(view, 3 * frame, frame);
  EXPECT_FALSE(script_.jumped);
  tracker.process_blind(320, 240, 4 * frame, frame, true);
  script_.throws = true;
  EXPECT_THROW(tracker.process(view, 5 * frame, frame), std::runtime_error);
  tracker.process_blind(320, 240, 5 * frame, frame);
  script_.throws = false;
  tracker.process(view, 6 * frame, frame);
  EXPECT_TRUE(script_.jumped);
}

/// 1500 of 65536 levels, shifted by a few, which a window tolerates. Only a new stream gets a new window.
TEST_F(TrackerLife, Gray16IsSeenThroughItsStreamsWindow) {
  const auto process = [this](Tracker &tracker, int from) {
    cv::Mat1w deep;
    texture_.convertTo(deep, CV_16U, 9, from);
    FrameView view = MovingScene::gray_view(deep);
    view.open_range = true;
    view.component[0] = {deep.ptr(), static_cast<std::ptrdiff_t>(deep.step[0]), 2, 2, 8};
    pts_ += second / 25;
    tracker.process(view, pts_);
    return script_.luma.clone();
  };
  const auto same = [](const cv::Mat &a, const cv::Mat &b) { return cv::norm(a, b, cv::NORM_INF) == 0; };
  Tracker tracker(with_points({{10, 20}}), std::make_unique<Scripted>()),
      other(with_points({{10, 20}}), std::make_unique<Scripted>());
  const cv::Mat first = process(tracker, 1000), second = process(tracker, 1040), anew = process(other, 1040);
  cv::Scalar mean, is, should;
  cv::meanStdDev(first, mean, is);
  cv::meanStdDev(texture_, mean, should);
  EXPECT_GT(is[0], should[0]) << "the full range of 8 bit is used";
  EXPECT_FALSE(same(first, second)) << "the window stays";
  EXPECT_TRUE(same(first, anew)) << "another stream has another window";
  tracker.reset();
  EXPECT_TRUE(same(process(tracker, 1040), anew));
}

TEST_F(TrackerLife, AGivenPointNeverEndsButADetectedOneDoes) {
  Settings settings;
  settings.max_features = 5;
  settings.forget_after = second;
  Tracker tracker(settings, std::make_unique<Scripted>());
  const auto first = tracker.add_point(50, 60);
  const auto &tracks = next(tracker);
  ASSERT_EQ(tracks.features.size(), 6u);
  for (const auto &f : tracks.features) script_.kinds[f.id] = Claim::Kind::lost;
  for (int i = 0; i < 25; ++i) next(tracker);
  for (const auto &f : tracks.features) EXPECT_EQ(f.state, FeatureState::lost) << "0.96 s";
  next(tracker);
  ASSERT_EQ(tracks.features.size(), 6u);
  for (const auto &f : tracks.features)
    EXPECT_EQ(f.state, f.id == first ? FeatureState::lost : FeatureState::ended) << f.id;
  next(tracker);
  ASSERT_EQ(tracks.features.size(), 1u);
  EXPECT_EQ(tracks.features[0].id, first);
  for (int i = 0; i < 100; ++i) next(tracker);
  EXPECT_EQ(tracks.features.size(), 1u) << "without replenishing there are no new features";
}

TEST_F(TrackerLife, ReplenishingGivesNewIds) {
  script_.replenishes = true;
  Settings settings;
  settings.max_features = 5;
  settings.forget_after = second / 5;
  Tracker tracker(settings, std::make_unique<Scripted>());
  const auto &tracks = next(tracker);
  ASSERT_EQ(tracks.features.size(), 5u);
  script_.kinds[2] = Claim::Kind::lost;
  std::size_t most = 0;
  int replaced = 0;
  for (int i = 1; i <= 30; ++i) {
    most = std::max(most, next(tracker).features.size());
    if (replaced == 0 && find(tracks, 5)) replaced = i;
  }
  ASSERT_NE(find(tracks, 5), nullptr);
  EXPECT_EQ(replaced, 13) << "half a second after the last detection";
  for (const auto &f : tracks.features)
    if (f.id != 5) {
      EXPECT_GE(std::hypot(f.x - find(tracks, 5)->x, f.y - find(tracks, 5)->y), 5.5) << "half a patch";
    }
  EXPECT_EQ(tracks.features.size(), 5u);
  EXPECT_EQ(find(tracks, 2), nullptr);
  EXPECT_LE(most, 6u);
}

TEST_F(TrackerLife, AChangeOfSizeEndsTheOldIdsAndRestartsThePointsWithNewIds) {
  Tracker tracker(with_points({{10, 20}, {100, 100}}), std::make_unique<Scripted>());
  next(tracker);
  cv::Mat larger;
  cv::resize(texture_, larger, {}, 2, 2);
  const auto &tracks = next(tracker, larger);
  ASSERT_EQ(tracks.features.size(), 4u);
  EXPECT_EQ(tracks.width, 640);
  EXPECT_EQ(tracks.features[0].state, FeatureState::ended);
  EXPECT_EQ(tracks.features[1].state, FeatureState::ended);
  EXPECT_EQ(tracks.features[2].id, 2u);
  EXPECT_EQ(tracks.features[2].x, 10);
  EXPECT_EQ(tracks.features[3].x, 100);
  EXPECT_EQ(script_.forgotten, 2);  // the first size counts as a change
  next(tracker, larger);
  EXPECT_EQ(tracks.features.size(), 2u);
}

TEST_F(TrackerLife, ResetEndsTheOldIdsAndRestartsThePoints) {
  Tracker tracker(with_points({{10, 20}}), std::make_unique<Scripted>());
  next(tracker);
  tracker.add_point(30, 30);  // before the reset, so it belongs to the old stream
  tracker.reset();
  const auto &tracks = next(tracker);
  ASSERT_EQ(tracks.features.size(), 2u);
  EXPECT_EQ(tracks.features[0].state, FeatureState::ended);
  EXPECT_EQ(tracks.features[1].x, 10);
  EXPECT_EQ(tracks.features[1].id, 2u);
  EXPECT_EQ(tracks.frame, 1u);
}

// As when a recording fades in. For two seconds from the first feature on, detection adds more. After that, only
// algorithms that replenish get new features.
TEST_F(TrackerLife, DetectionFollowsAFadeIn) {
  Settings settings;
  settings.max_features = 20;
  const auto detected_with_all_of_it_from = [&](int frame) {
    Tracker tracker(settings, std::make_unique<Scripted>());
    cv::Mat part(texture_.size(), CV_8UC1, cv::Scalar(0));
    texture_(cv::Rect(140, 100, 40, 40)).copyTo(part(cv::Rect(140, 100, 40, 40)));
    for (int i = 0; i < 80; ++i) next(tracker, i < frame ? part : texture_);
    return next(tracker, texture_).features.size();
  };
  EXPECT_EQ(detected_with_all_of_it_from(30), 20u);
  EXPECT_LT(detected_with_all_of_it_from(55), 20u);
}

TEST_F(TrackerLife, PointsComeAndGoByRequest) {
  Settings settings;
  settings.max_features = 0;
  Tracker tracker(settings, std::make_unique<Scripted>());
  EXPECT_TRUE(next(tracker).features.empty());
  const auto id = tracker.add_point(12.5, 13);
  EXPECT_EQ(id, 0u);
  const auto &tracks = next(tracker);
  ASSERT_EQ(tracks.features.size(), 1u);
  EXPECT_EQ(tracks.features[0].x, 12.5);
  EXPECT_TRUE(tracker.remove_point(id));
  EXPECT_TRUE(tracker.remove_point(tracker.add_point(14, 15))) << "removed before its first frame, it never appears";
  next(tracker);
  ASSERT_EQ(ids(tracks), (std::vector<FeatureId>{id}));
  EXPECT_EQ(tracks.features[0].state, FeatureState::ended);
  EXPECT_TRUE(next(tracker).features.empty());
  EXPECT_EQ(tracker.add_point(std::nan(""), 1), no_feature);
  EXPECT_EQ(tracker.add_point(1, std::numeric_limits<double>::infinity()), no_feature);
}

TEST_F(TrackerLife, AnotherThreadMaySendRequestsDuringFrames) {
  Tracker tracker(with_points({{10, 20}}), std::make_unique<Scripted>());
  std::atomic<bool> at_work = true;
  std::vector<FeatureId> kept = {0};
  std::thread other([&] {
    for (std::uint64_t i = 0, frames = 0; i < 60; frames = tracker.stats().frames, ++i) {
      kept.push_back(tracker.add_point(10, 20));
      EXPECT_TRUE(tracker.remove_point(tracker.add_point(30, 40)));
      EXPECT_GE(tracker.stats().frames, frames);
      std::this_thread::yield();
    }
    at_work = false;
  });
  while (at_work) next(tracker);
  other.join();
  next(tracker);
  EXPECT_EQ(ids(next(tracker)), kept) << "the removed points have been reported as ended";
}

TEST_F(TrackerLife, AnotherThreadMayResetAndRemoveTheNearest) {
  Tracker tracker(with_points({{10, 20}, {30, 40}}), std::make_unique<Scripted>());
  std::atomic<bool> at_work = true;
  std::thread other([&] {
    for (int i = 0; i < 60; ++i) {
      tracker.remove_nearest(10, 20);
      if (i % 4 == 3) tracker.reset();
      std::this_thread::yield();
    }
    at_work = false;
  });
  while (at_work) next(tracker);
  other.join();
  next(tracker);
  EXPECT_EQ(next(tracker).features.size(), 2u) << "the last request is a reset";
}

TEST_F(TrackerLife, BlackFramesHaveNoFeaturesAndDetectionIsRetried) {
  Settings settings;
  settings.max_features = 8;
  Tracker tracker(settings, std::make_unique<Scripted>());
  const cv::Mat black(240, 320, CV_8UC1, cv::Scalar(0)), white(240, 320, CV_8UC1, cv::Scalar(255));
  EXPECT_TRUE(next(tracker, black).features.empty());
  EXPECT_TRUE(next(tracker, white).features.empty());
  const auto &tracks = next(tracker);
  EXPECT_EQ(tracks.features.size(), 8u);
  for (const auto &f : tracks.features) {
    EXPECT_TRUE(std::isfinite(f.x) && std::isfinite(f.y));
    EXPECT_TRUE(f.x > 0 && f.x < 320 && f.y > 0 && f.y < 240);
  }
}

TEST_F(TrackerLife, DetectionStaysInItsRegion) {
  Settings settings;
  settings.max_features = 10;
  settings.region = {200, 100, 80, 90};
  Tracker tracker(settings, std::make_unique<Scripted>());
  const auto &tracks = next(tracker);
  ASSERT_FALSE(tracks.features.empty());
  for (const auto &f : tracks.features) EXPECT_TRUE(settings.region.contains(cv::Point(cvRound(f.x), cvRound(f.y))));
}

TEST_F(TrackerLife, DetectionAvoidsHighlightsAsSet) {
  Settings settings;
  settings.max_features = 10;
  Tracker by_default(settings, std::make_unique<Scripted>());
  EXPECT_EQ(next(by_default).features.size(), 10u);
  settings.specular.value = 0.1;  // V of the darkest pixel is 40/255, and gray has no saturation
  Tracker all_bright(settings, std::make_unique<Scripted>());
  EXPECT_TRUE(next(all_bright).features.empty());
}

TEST_F(TrackerLife, APictureSmallerThanAPatchOrAPyramidHasNoFeatures) {
  Tracker flat({}, std::make_unique<Scripted>()), tracker(with_points({{0, 0}}), std::make_unique<Scripted>());
  for (const int side : {15, 16}) EXPECT_EQ(next(flat, cv::Mat(side, 40, CV_8UC1, 9.)).too_small, side < 16);
  const auto &tracks = next(tracker, cv::Mat(1, 1, CV_8UC1, 9.));
  EXPECT_TRUE(tracks.too_small);
  ASSERT_EQ(tracks.features.size(), 1u);
  EXPECT_EQ(tracks.features[0].state, FeatureState::lost);
}

TEST_F(TrackerLife, APointGivenDuringBlackBeginsLater) {
  Tracker tracker(with_points({{100, 100}}), std::make_unique<Scripted>());
  tracker.process_blind(320, 240, 0);
  const auto second_point = tracker.add_point(50, 60);
  const auto &tracks = tracker.process_blind(320, 240, second / 25);
  ASSERT_EQ(tracks.features.size(), 2u);
  EXPECT_EQ(tracks.features[0].state, FeatureState::lost);
  pts_ = 2 * second / 25;
  next(tracker);
  ASSERT_EQ(tracks.features.size(), 2u) << "with the same ids";
  EXPECT_EQ(tracks.features[0].id, 0u);
  EXPECT_EQ(tracks.features[0].state, FeatureState::learning);
  EXPECT_EQ(find(tracks, second_point)->state, FeatureState::learning);
  EXPECT_EQ(script_.begun, (std::vector<FeatureId>{0, 1}));
}

TEST_F(TrackerLife, DetectedFeaturesOnBurntInGraphicsEndGivenPointsStay) {
  // A moving texture under a still caption. Detection puts features on it, as on any corner.
  const cv::Rect caption(240, 226, 175, 26);
  cv::Mat noise(600, 800, CV_8UC1), texture;
  cv::RNG rng(3);
  rng.fill(noise, cv::RNG::UNIFORM, 0, 256);
  cv::GaussianBlur(noise, texture, {0, 0}, 3);
  cv::normalize(texture, texture, 30, 130, cv::NORM_MINMAX);
  const auto frame = [&](int i) {
    cv::Mat moved = texture(cv::Rect(i % 150, i % 110, 640, 480)).clone();
    cv::putText(moved, "LASER OFF", {240, 250}, cv::FONT_HERSHEY_SIMPLEX, 1, cv::Scalar(205),
                2);  // too dark for a highlight
    return moved;
  };
  Settings settings;
  settings.max_features = 6;
  settings.region = caption;
  settings.forget_after = 0;
  for (const bool moves : {false, true}) {
    script_.motion = {moves ? 2.0 : 0.0, 0};  // away from the graphics, onto tissue
    Tracker tracker(settings, std::make_unique<Scripted>());
    const auto mine = tracker.add_point(410, 248);
    std::size_t detected = 0, ended = 0;
    for (int i = 0; i < 100; ++i)
      for (const auto &f : next(tracker, frame(i)).features) {
        if (f.id == mine) {
          EXPECT_NE(f.state, FeatureState::ended);
        } else {
          detected += i == 0;
          ended += f.state == FeatureState::ended;
        }
      }
    EXPECT_GT(detected, 0u);
    EXPECT_EQ(ended, moves ? 0 : detected);
  }
}

TEST_F(TrackerLife, StatsCountFramesAndStates) {
  Tracker tracker(with_points({{10, 20}, {400, 20}}), std::make_unique<Scripted>());
  next(tracker);
  next(tracker);
  const auto stats = tracker.stats();
  EXPECT_EQ(stats.frames, 2u);
  EXPECT_EQ(stats.detected, 2u);
  EXPECT_EQ(stats.features[static_cast<std::size_t>(FeatureState::tracked)], 1u);
  EXPECT_EQ(stats.features[static_cast<std::size_t>(FeatureState::out)], 1u);
}

TEST_F(TrackerLife, PointsFromTheStartKeepTheirIds) {
  Settings settings;
  settings.points_from_start = true;
  Tracker tracker(settings, std::make_unique<Scripted>());
  EXPECT_TRUE(next(tracker).features.empty());  // no detection
  const auto id = tracker.add_point(50, 60);
  EXPECT_EQ(id, max_points);
  tracker.offer_start({{7, {10, 20}}, {3, {30, 40}}, {max_points, {1, 1}}, {8, {std::nan(""), 1}}, {3, {9, 9}}});
  const auto &tracks = next(tracker);
  ASSERT_EQ(tracks.features.size(), 3U);
  EXPECT_EQ(tracks.features[0].id, 3U);
  EXPECT_EQ(tracks.features[0].x, 30);
  EXPECT_EQ(tracks.features[1].id, 7U);
  EXPECT_EQ(tracks.features[2].id, id);
  // During a stream, an offer is ignored.
  tracker.offer_start({{9, {10, 20}}});
  EXPECT_EQ(find(next(tracker), 9), nullptr);
  EXPECT_EQ(find(next(tracker), 9), nullptr);
}

TEST_F(TrackerLife, PointsFromTheStartComeBackWithTheirIdsAfterAReset) {
  Settings settings;
  settings.points_from_start = true;
  Tracker tracker(settings, std::make_unique<Scripted>());
  tracker.offer_start({{2, {10, 20}}, {5, {30, 40}}});
  next(tracker);
  next(tracker);
  tracker.reset();
  tracker.offer_start({{2, {110, 120}}});
  const auto &tracks = next(tracker);
  ASSERT_EQ(tracks.features.size(), 2U);
  EXPECT_EQ(tracks.features[0].id, 2U);
  EXPECT_EQ(tracks.features[0].state, FeatureState::learning);
  EXPECT_EQ(tracks.features[0].x, 110);
  EXPECT_EQ(tracks.features[1].state, FeatureState::ended);
  EXPECT_EQ(next(tracker).features.size(), 1U);
  // An empty offer begins nothing; the next one does.
  tracker.reset();
  EXPECT_EQ(find(next(tracker), 2)->state, FeatureState::ended);
  tracker.offer_start({});
  EXPECT_TRUE(next(tracker).features.empty());
  tracker.offer_start({{4, {1, 2}}});
  EXPECT_EQ(next(tracker).features.size(), 1U);
}

}  // namespace
}  // namespace csd
