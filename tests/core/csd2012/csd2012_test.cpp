// SPDX-License-Identifier: LGPL-2.1-or-later
#include "csd2012/csd2012.h"
#include "algorithms/make_algorithm.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <set>
#include <thread>

#include "csd2012/easy_scene.h"

namespace csd {
namespace {

TEST(Csd2012, HandsOverToTheDescriptorAndFollowsTheTexture) {
  const auto all = run(few_features(), 1, 40);
  ASSERT_EQ(all[0].features.size(), 12u);
  int learning = 0, claims = 0, right = 0;
  for (std::size_t i = 0; i < all.size(); ++i)
    for (const auto &f : all[i].features) {
      const auto &start = all[0].features[f.id];
      EXPECT_TRUE(std::isfinite(f.x) && std::isfinite(f.y));
      learning += i == 7 && f.state == FeatureState::learning;
      if (i <= 8) continue;
      EXPECT_NE(f.state, FeatureState::learning) << "frame " << i;
      if (f.state != FeatureState::tracked) continue;
      ++claims;
      const auto at = sway(static_cast<int>(i)) - sway(0);
      right += std::hypot(f.x - start.x - at.x, f.y - start.y - at.y) <= 3;
    }
  EXPECT_EQ(learning, 12);
  // The paper's tracker on an easy scene: it must see most features in most of 31 frames, and mostly in place.
  EXPECT_GT(claims, 12 * 31 * 3 / 4);
  EXPECT_GT(right, claims * 9 / 10);
}

TEST(Csd2012, WithSyncLearningTracksAreTheSameForAnyNumberOfThreads) {
  const auto one = run(few_features(), 1, 30);
  EXPECT_TRUE(same_tracks(one, run(few_features(), 1, 30)));
  EXPECT_TRUE(same_tracks(one, run(few_features(), 4, 30)));
}

TEST(Csd2012, TracksDependOnTheSeed) {
  auto settings = few_features();
  const auto one = run(settings, 2, 20);
  settings.seed = 2;
  const auto other = run(settings, 2, 20);
  EXPECT_FALSE(same_tracks(one, other));
}

// Each in its own thread, as in eight elements. TSan watches.
TEST(Csd2012, EightTrackersInOneProcessAreIndependent) {
  const auto alone = run(few_features(), 1, 15);
  const MovingScene scene;
  ThreadPool pool(2);
  std::vector<std::vector<Tracks>> all(8);
  std::vector<std::thread> streams;
  for (auto &tracks : all)
    streams.emplace_back([&] {
      Tracker tracker(few_features(), make_algorithm(few_features(), pool));
      for (int i = 0; i < 15; ++i) {
        const auto picture = scene.render(sway(i));
        tracks.push_back(tracker.process(MovingScene::view(picture), i * frame_time));
      }
    });
  for (auto &stream : streams) stream.join();
  for (const auto &tracks : all) EXPECT_TRUE(same_tracks(alone, tracks));
}

TEST(Csd2012, AHiddenFeatureIsReportedHiddenAndFoundAgain) {
  auto settings = few_features();
  settings.points = {{160, 120}};
  const MovingScene scene;
  ThreadPool pool(1);
  Tracker tracker(settings, make_algorithm(settings, pool));
  int hidden = 0;
  Feature last;
  for (int i = 0; i < 60; ++i) {
    auto picture = scene.render({0, 0});
    if (i >= 20 && i < 40) picture(cv::Rect(90, 50, 140, 140)).setTo(cv::Scalar(90, 90, 90));
    last = tracker.process(MovingScene::view(picture), i * frame_time).features.at(0);
    if (i >= 20 && i < 40) hidden += last.state == FeatureState::occluded;
    if (i == 19) {
      EXPECT_EQ(last.state, FeatureState::tracked);
    }
  }
  // The tree has never seen such a patch and may accept it. The feature must be hidden in most frames all the same.
  EXPECT_GE(hidden, 16);
  EXPECT_EQ(last.state, FeatureState::tracked);
  EXPECT_LE(std::hypot(last.x - 160, last.y - 120), 3);
}

/// Hides the scene for `hidden` frames while it moves by `jump`. How many of four points are found in the first frame
/// after that.
int found_after_a_jump(cv::Point2d jump, int hidden) {
  auto settings = few_features();
  settings.points = {{110, 100}, {160, 120}, {200, 90}, {130, 150}};
  const MovingScene scene;
  ThreadPool pool(1);
  Tracker tracker(settings, make_algorithm(settings, pool));
  int found = 0;
  for (int i = 0; i <= 20 + hidden; ++i) {
    auto picture = scene.render(i < 20 + hidden ? cv::Point2d(0, 0) : jump);
    // A ramp, brighter to the right: no order of pixels that the tree has learnt.
    if (i >= 20 && i < 20 + hidden)
      for (int x = 0; x < picture.cols; ++x) picture.col(x).setTo(cv::Scalar::all(40 + x / 2));
    for (const auto &f : tracker.process(MovingScene::view(picture), i * frame_time).features)
      found += i == 20 + hidden && f.state == FeatureState::tracked &&
               cv::norm(cv::Point2d(f.x, f.y) - settings.points[f.id] - jump) <= 3;
  }
  return found;
}

// At 240 lines the window's radius is 10 px, and 20 px after four frames without the feature.
TEST(Csd2012, TheWindowGrowsWhileAFeatureIsHidden) {
  EXPECT_GE(found_after_a_jump({6, 0}, 0), 3);
  EXPECT_EQ(found_after_a_jump({16, 0}, 0), 0);
  EXPECT_GE(found_after_a_jump({16, 0}, 10), 3);
  EXPECT_EQ(found_after_a_jump({28, 0}, 10), 0);
}

// §2.1.5: each success adds a positive. After the training, a copy of the feature appears. It is a false match in each
// frame, hence a negative, and no node test separates it from the feature. Without new positives it would soon
// outnumber the training's positives in their leaf.
TEST(Csd2012, SuccessesProtectAFeatureFromItsCopy) {
  auto settings = few_features();
  settings.points = {{160, 120}};
  settings.search_radius = 16;
  const MovingScene scene;
  ThreadPool pool(1);
  Tracker tracker(settings, make_algorithm(settings, pool));
  int tracked = 0;
  for (int i = 0; i < 90; ++i) {
    auto picture = scene.render({0, 0});
    // The patch is 11 × 11.
    if (i >= 12) picture(cv::Rect(154, 114, 13, 13)).copyTo(picture(cv::Rect(154 + 13, 114, 13, 13)));
    const auto &f = tracker.process(MovingScene::view(picture), i * frame_time).features.at(0);
    if (i >= 50) tracked += f.state == FeatureState::tracked && std::hypot(f.x - 160, f.y - 120) <= 3;
  }
  EXPECT_EQ(tracked, 40);
}

// Afterwards, the paper's tracker may accept what lies beside it.
TEST(Csd2012, IsOutBeyondTheEdge) {
  auto settings = few_features();
  for (int y = 40; y < 210; y += 16) settings.points.push_back({310, static_cast<double>(y)});
  ThreadPool pool(1);
  Tracker tracker(settings, make_algorithm(settings, pool));
  std::set<FeatureId> out;
  for (int i = 0; i < 60; ++i) {
    const auto picture = MovingScene().render({i < 20 ? 0.0 : std::min(i - 20, 38) * 1.0, 0});
    for (const auto &f : tracker.process(MovingScene::view(picture), i * frame_time).features) {
      if (f.state == FeatureState::out) out.insert(f.id);
      EXPECT_TRUE(i != 19 || f.state == FeatureState::tracked);
    }
  }
  EXPECT_GT(out.size(), settings.points.size() / 2) << "of " << settings.points.size();
}

TEST(Csd2012, TrainsForTheTrainingTime) {
  auto settings = few_features();
  settings.max_features = 2;
  settings.training_time = second;
  const auto all = run(settings, 2, 27);
  for (const auto &f : all[24].features) EXPECT_EQ(f.state, FeatureState::learning) << "0.96 s";
  for (const auto &f : all[25].features) EXPECT_NE(f.state, FeatureState::learning) << "1 s";
}

// From a long training-time it takes 32 frames, evenly spread: here every second of 50.
TEST(Csd2012, LearnsFromEvenlySpreadFrames) {
  class Never final : public Executor {
    void post(std::function<void()>) override {}
  } never;
  auto settings = few_features();
  settings.learn_synchronously = false;
  settings.points = {{160, 120}};
  settings.training_time = 2 * second;
  const MovingScene scene;
  Tracker tracker(settings, make_algorithm(settings, never));
  for (int i = 0; i < 20; ++i) tracker.process(MovingScene::view(scene.render(sway(i))), i * frame_time);
  EXPECT_EQ(tracker.stats().queue, 10u);
}

// Where LK fails, the descriptor takes over with what it has learnt so far.
TEST(Csd2012, TheDescriptorTakesOverWhereLkFails) {
  auto settings = few_features();
  settings.points = {{160, 120}};
  const MovingScene scene;
  ThreadPool pool(1);
  Tracker tracker(settings, make_algorithm(settings, pool));
  for (int i = 0; i < 10; ++i) {
    auto picture = scene.render({0, 0});
    if (i == 4) picture.setTo(cv::Scalar(90, 90, 90));
    const auto state = tracker.process(MovingScene::view(picture), i * frame_time).features.at(0).state;
    if (i < 4) {
      EXPECT_EQ(state, FeatureState::learning);
    } else {
      EXPECT_EQ(state, i == 4 ? FeatureState::occluded : FeatureState::tracked) << i;
    }
  }
}

// The exact patch it learnt is the best place. The middle of similar patches is close to it.
TEST(Csd2012, InAStillSceneADescriptorFindsTheExactPlace) {
  auto settings = few_features();
  settings.points = {{110, 100}, {160, 120}, {200, 90}, {130, 150}};
  const MovingScene scene;
  for (const auto &[spread, off] : {std::pair{0.0, 0.0}, std::pair{2.0, 1.0}}) {
    csd2012::Choices choices;
    choices.cluster_radius = choices.smoothing = spread;
    ThreadPool pool(1);
    Tracker tracker(settings, std::make_unique<Csd2012>(settings, pool, choices));
    for (int i = 0; i < 10; ++i)
      for (const auto &f : tracker.process(MovingScene::view(scene.render({0, 0})), i * frame_time).features)
        if (i == 8) {
          EXPECT_EQ(f.state, FeatureState::tracked);
          EXPECT_LE(cv::norm(cv::Point2d(f.x, f.y) - settings.points[f.id]), off) << spread;
        }
  }
}

// Where the tracker forbids tissue, neither the learner nor the tracking descriptor evaluates anything.
TEST(Csd2012, LearnersRespectTheForbiddenArea) {
  const MovingScene scene;
  const auto picture = scene.render({0, 0});
  WorkFrame frame;
  frame.load(MovingScene::view(picture));
  std::vector<Claim> claims{{0, Claim::Kind::hidden, {160, 120}}};
  const cv::Mat nowhere, everywhere(240, 320, CV_8UC1, cv::Scalar(255));
  const auto errors = [&](const cv::Mat &forbidden) {
    ThreadPool pool(1);
    Csd2012 algorithm(few_features(), pool);
    algorithm.begin(0, {160, 120}, {frame, forbidden, 0});
    algorithm.finish({frame, forbidden, 0});
    for (int i = 1; i < 20; ++i) {
      algorithm.track({frame, forbidden, i * frame_time}, claims);
      algorithm.finish({frame, forbidden, i * frame_time});
    }
    EXPECT_EQ(claims[0].kind, Claim::Kind::tracked);
    Stats stats;
    algorithm.add_to(stats);
    return stats.false_correspondences;
  };
  EXPECT_GT(errors(nowhere), 0u);
  EXPECT_EQ(errors(everywhere), 0u);
}

TEST(Csd2012, TheStreamingThreadNeverWaitsForLearning) {
  class Never final : public Executor {
    void post(std::function<void()>) override {}
  } never;
  auto settings = few_features();
  settings.learn_synchronously = false;
  const MovingScene scene;
  Tracker tracker(settings, make_algorithm(settings, never));
  for (int i = 0; i < 60; ++i) {
    const auto picture = scene.render(sway(i));
    for (const auto &f : tracker.process(MovingScene::view(picture), i * frame_time).features)
      EXPECT_EQ(f.state, FeatureState::learning) << "there is no descriptor yet, so LK goes on";
  }
  EXPECT_GT(tracker.stats().queue, 0u);
}

TEST(Csd2012, LearnsBesideTheStream) {
  auto settings = few_features();
  settings.learn_synchronously = false;
  const MovingScene scene;
  ThreadPool pool(2);
  Tracker tracker(settings, make_algorithm(settings, pool));
  std::atomic<bool> done = false;
  std::thread reader([&] {
    std::uint64_t learned = 0;
    while (!done) {
      const auto now = tracker.stats().learned;
      EXPECT_GE(now, learned);
      learned = now;
      std::this_thread::yield();
    }
  });
  auto next = [&, i = 0]() mutable -> const Tracks & {
    const auto picture = scene.render(sway(i));
    return tracker.process(MovingScene::view(picture), i++ * frame_time);
  };
  for (int i = 0; i < 12; ++i) next();
  for (int i = 0; i < 2; ++i) {
    while (tracker.stats().queue > 0) std::this_thread::yield();
    next();  // hands over; from the next frame on, the descriptors search
  }
  const auto &tracks = next();
  EXPECT_EQ(tracker.stats().learned, 12u);
  int tracked = 0;
  for (const auto &f : tracks.features) {
    EXPECT_NE(f.state, FeatureState::learning) << f.id;
    tracked += f.state == FeatureState::tracked;
  }
  EXPECT_GE(tracked, 8);
  tracker.remove_point(3);
  next();
  done = true;
  reader.join();
  // The tracker is destroyed with jobs of its learners still in the queue.
}

TEST(Csd2012, StatsCountLearning) {
  const MovingScene scene;
  ThreadPool pool(1);
  Tracker tracker(few_features(), make_algorithm(few_features(), pool));
  for (int i = 0; i < 20; ++i) tracker.process(MovingScene::view(scene.render(sway(i))), i * frame_time);
  const auto stats = tracker.stats();
  EXPECT_EQ(stats.learned, 12u);
  EXPECT_GT(stats.retrainings, 0u);
  EXPECT_GT(stats.false_correspondences, 0u);
  EXPECT_GT(stats.learning_time, 0);
  EXPECT_EQ(stats.queue, 0u);
}

// Over the edge, LK fails long before the end of training-time, so the descriptor takes over early.
TEST(Csd2012, StatsCountADescriptorThatReplacesAFailedLk) {
  class Never final : public Executor {
    void post(std::function<void()>) override {}
  } never;
  ThreadPool pool(1);
  const MovingScene scene;
  for (const bool learns : {true, false}) {
    auto settings = few_features();
    settings.points = {{300, 120}};
    settings.training_time = second;
    settings.learn_synchronously = learns;
    Tracker tracker(settings, make_algorithm(settings, learns ? static_cast<Executor &>(pool) : never));
    FeatureState state{};
    for (int i = 0; i < 12; ++i) {
      const auto picture = scene.render({3.0 * i, 0});
      state = tracker.process(MovingScene::view(picture), i * frame_time).features.at(0).state;
      if (i == 3) {
        EXPECT_EQ(state, FeatureState::learning);
        EXPECT_EQ(tracker.stats().learned, 0u);
      }
    }
    EXPECT_NE(state, FeatureState::learning);
    EXPECT_EQ(tracker.stats().learned, learns ? 1u : 0u) << "without a descriptor, none can take over";
  }
}

TEST(Csd2012, NoiseAndFlatPicturesGiveFiniteNumbers) {
  auto settings = few_features();
  settings.points = {{160, 120}, {2, 2}, {318, 238}, {400, -3}};
  ThreadPool pool(1);
  Tracker tracker(settings, make_algorithm(settings, pool));
  cv::RNG rng(9);
  for (int i = 0; i < 40; ++i) {
    cv::Mat picture(240, 320, CV_8UC3, cv::Scalar::all(i % 4 == 0 ? 0 : 255));
    if (i % 4 > 1) rng.fill(picture, cv::RNG::UNIFORM, 0, 256);
    const auto &tracks = tracker.process(MovingScene::view(picture), i * frame_time);
    ASSERT_EQ(tracks.features.size(), 4u);
    for (const auto &f : tracks.features) {
      EXPECT_TRUE(std::isfinite(f.x) && std::isfinite(f.y) && std::isfinite(f.confidence));
      EXPECT_EQ(f.confidence > 0, claims_position(f.state));
    }
    EXPECT_EQ(tracks.features[3].state, FeatureState::out);
  }
}

}  // namespace
}  // namespace csd
