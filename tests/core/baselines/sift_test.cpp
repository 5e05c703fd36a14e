// SPDX-License-Identifier: LGPL-2.1-or-later
#include "baselines/sift.h"

#include <gtest/gtest.h>

#include <cmath>

#include "algorithms/make_algorithm.h"
#include "track/moving_scene.h"
#include "track/tracker.h"

namespace csd {
namespace {

class NoExecutor final : public Executor {
  void post(std::function<void()>) override { FAIL() << "SIFT learns nothing"; }
};

TEST(RatioTest, TakesTheNearestIfTheSecondIsFarEnough) {
  // Distances from (0,0): 5, 10, 3.
  const cv::Mat candidates = (cv::Mat_<float>(3, 2) << 3, 4, 6, 8, 0, -3);
  const cv::Mat wanted = (cv::Mat_<float>(1, 2) << 0, 0);
  EXPECT_EQ(match_by_ratio(wanted, candidates, 0.61), std::vector<int>{2});  // 3 < .61 · 5
  EXPECT_EQ(match_by_ratio(wanted, candidates, 0.6), std::vector<int>{-1});  // 3 is not less than .6 · 5
  const cv::Mat two = (cv::Mat_<float>(2, 2) << 5, 9, 0, 0);
  // (5,9): 2.24 to (6,8), 5.39 to (3,4); (0,0) as above.
  EXPECT_EQ(match_by_ratio(two, candidates, 0.6), (std::vector<int>{1, -1}));
}

TEST(RatioTest, NeedsTwoCandidates) {
  const cv::Mat one = (cv::Mat_<float>(1, 2) << 3, 4);
  EXPECT_EQ(match_by_ratio(one, one, 0.6), std::vector<int>{-1});
  EXPECT_EQ(match_by_ratio(one, cv::Mat(), 0.6), std::vector<int>{-1});
  EXPECT_TRUE(match_by_ratio(cv::Mat(), one, 0.6).empty());
}

Settings sift(unsigned features) {
  Settings settings;
  settings.algorithm = AlgorithmKind::sift;
  settings.max_features = features;
  settings.forget_after = 0;
  settings.content_area = ContentArea::full;
  return settings;
}

/// The scene, turned about the picture's middle.
struct Turned {
  explicit Turned(double degrees) {
    const auto m = cv::getRotationMatrix2D({159.5f, 119.5f}, degrees, 1);
    m.copyTo(matrix);
  }
  cv::Mat render(const MovingScene &scene) const {
    cv::Mat out;
    cv::warpAffine(scene.render({0, 0}), out, matrix, {320, 240}, cv::INTER_LINEAR, cv::BORDER_REFLECT_101);
    return out;
  }
  cv::Point2d move(cv::Point2d p) const {
    const cv::Vec2d q = matrix * cv::Vec3d(p.x, p.y, 1);
    return {q[0], q[1]};
  }
  cv::Matx23d matrix;
};

struct Tally {
  int right = 0, wrong = 0;
};

template <class Truth>
Tally tally(const Tracks &tracks, const std::vector<Feature> &first, Truth truth) {
  Tally t;
  for (std::size_t i = 0; i < first.size(); ++i) {
    const auto &f = tracks.features.at(i);
    if (f.state != FeatureState::tracked) continue;
    EXPECT_EQ(f.confidence, 1);
    const auto p = truth(cv::Point2d(first[i].x, first[i].y));
    ++(std::hypot(f.x - p.x, f.y - p.y) < 1.5 ? t.right : t.wrong);
  }
  return t;
}

TEST(Sift, FindsARigidSceneFromOneFrame) {
  NoExecutor none;
  const MovingScene scene;
  Tracker tracker(sift(30), make_algorithm(sift(30), none));
  const auto first = tracker.process(MovingScene::view(scene.render({0, 0})), 0).features;
  ASSERT_EQ(first.size(), 30u);
  // 39 pixels in one step: without overlap, small displacement or frames in between.
  const auto picture = scene.render({31, -24});
  const auto t = tally(tracker.process(MovingScene::view(picture), second / 25), first,
                       [](cv::Point2d p) { return p + cv::Point2d(31, -24); });
  EXPECT_GT(t.right, 10);
  EXPECT_LE(t.wrong, 1);
}

TEST(Sift, FindsARotatedScene) {
  NoExecutor none;
  const MovingScene scene;
  const Turned turned(50);
  Tracker tracker(sift(30), make_algorithm(sift(30), none));
  const auto first = tracker.process(MovingScene::view(scene.render({0, 0})), 0).features;
  const auto picture = turned.render(scene);
  const auto t = tally(tracker.process(MovingScene::view(picture), second / 25), first,
                       [&](cv::Point2d p) { return turned.move(p); });
  EXPECT_GT(t.right, 8);
  EXPECT_LE(t.wrong, 1);
}

TEST(Sift, HidesACoveredFeatureAndFindsItAgain) {
  NoExecutor none;
  const MovingScene scene;
  Tracker tracker(sift(20), make_algorithm(sift(20), none));
  const auto picture = scene.render({0, 0});
  const cv::Mat flat(240, 320, CV_8UC3, cv::Scalar(80, 80, 80));
  const auto first = tracker.process(MovingScene::view(picture), 0).features;
  for (const auto &f : tracker.process(MovingScene::view(flat), second / 25).features) {
    EXPECT_EQ(f.state, FeatureState::occluded);
    EXPECT_EQ(f.confidence, 0);
  }
  for (const auto &f : tracker.process(MovingScene::view(flat), 3 * second).features)
    EXPECT_EQ(f.state, FeatureState::lost);
  const auto t = tally(tracker.process(MovingScene::view(picture), 4 * second), first, [](cv::Point2d p) { return p; });
  EXPECT_GT(t.right, 10);
  EXPECT_EQ(t.wrong, 0);
}

// §3.1: the feature must be "globally unique in the image".
TEST(Sift, RefusesRepeatedTexture) {
  NoExecutor none;
  const MovingScene scene({160, 240});
  cv::Mat twice;
  const auto half = scene.render({0, 0});
  cv::hconcat(half, half, twice);
  Tracker tracker(sift(40), make_algorithm(sift(40), none));
  tracker.process(MovingScene::view(twice), 0);
  int claimed = 0, away_from_seam = 0;
  for (const auto &f : tracker.process(MovingScene::view(twice), second / 25).features) {
    // Near the seam or the edges, the two halves look different.
    const double x = std::fmod(f.x, 160);
    if (x < 40 || x > 120) continue;
    ++away_from_seam;
    claimed += f.state == FeatureState::tracked;
  }
  ASSERT_GT(away_from_seam, 10);
  EXPECT_LT(claimed, away_from_seam / 4);
}

// §3.2.1: repeatability is low where contrast is low.
TEST(Sift, LosesAFadingFeature) {
  NoExecutor none;
  const MovingScene scene;
  Tracker tracker(sift(30), make_algorithm(sift(30), none));
  const auto picture = scene.render({0, 0});
  tracker.process(MovingScene::view(picture), 0);
  const cv::Mat faded = picture * 0.04 + cv::Scalar(100, 100, 100);
  for (const auto &f : tracker.process(MovingScene::view(faded), second / 25).features)
    EXPECT_EQ(f.state, FeatureState::occluded);
}

TEST(Sift, RemovingAFeatureLeavesTheOthers) {
  NoExecutor none;
  const MovingScene scene;
  auto settings = sift(30);
  settings.replenish = false;
  Tracker tracker(settings, make_algorithm(settings, none));
  const auto picture = scene.render({0, 0});
  tracker.process(MovingScene::view(picture), 0);
  EXPECT_TRUE(tracker.remove_point(1));
  auto rest = tracker.process(MovingScene::view(picture), second / 25).features;
  ASSERT_EQ(rest.at(1).state, FeatureState::ended);
  rest.erase(rest.begin() + 1);
  const auto &after = tracker.process(MovingScene::view(picture), 2 * second / 25).features;
  ASSERT_EQ(after.size(), rest.size());
  ASSERT_GT(after.size(), 20u);
  for (std::size_t i = 0; i < after.size(); ++i) {
    EXPECT_EQ(after[i].id, rest[i].id);
    EXPECT_EQ(after[i].state, rest[i].state);
    EXPECT_EQ(after[i].x, rest[i].x);
    EXPECT_EQ(after[i].y, rest[i].y);
  }
}

TEST(Sift, DoesNotFindAPointWithoutAKeypoint) {
  NoExecutor none;
  auto settings = sift(0);
  settings.points = {{160, 120}};
  Tracker tracker(settings, make_algorithm(settings, none));
  const cv::Mat flat(240, 320, CV_8UC3, cv::Scalar(80, 80, 80));
  EXPECT_EQ(tracker.process(MovingScene::view(flat), 0).features.at(0).state, FeatureState::tracked);
  EXPECT_EQ(tracker.process(MovingScene::view(flat), second / 25).features.at(0).state, FeatureState::occluded);
}

TEST(Sift, AcceptsTheSmallestPictures) {
  NoExecutor none;
  auto settings = sift(0);
  settings.points = {{8, 8}};
  Tracker tracker(settings, make_algorithm(settings, none));
  const cv::Mat tiny(16, 16, CV_8UC3, cv::Scalar::all(90));  // without a keypoint
  tracker.process(MovingScene::view(tiny), 0);
  const auto &feature = tracker.process(MovingScene::view(tiny), second / 25).features.at(0);
  EXPECT_EQ(feature.state, FeatureState::occluded);
  EXPECT_EQ(feature.x, 8);
  EXPECT_EQ(feature.y, 8);
}

}  // namespace
}  // namespace csd
