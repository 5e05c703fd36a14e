// SPDX-License-Identifier: LGPL-2.1-or-later
#include "baselines/lk.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <opencv2/core.hpp>

#include "algorithms/make_algorithm.h"
#include "track/moving_scene.h"
#include "track/tracker.h"

namespace csd {
namespace {

class NoExecutor final : public Executor {
  void post(std::function<void()>) override { FAIL() << "LK learns nothing"; }
};

Settings lk(std::vector<cv::Point2d> points) {
  Settings settings;
  settings.algorithm = AlgorithmKind::lk;
  settings.points = std::move(points);
  return settings;
}

TEST(LucasKanade, FollowsToAFractionOfAPixel) {
  NoExecutor none;
  const MovingScene scene;
  Tracker tracker(lk({{160, 120}, {90.5, 70.25}}), make_algorithm(lk({{160, 120}, {90.5, 70.25}}), none));
  for (int i = 0; i <= 20; ++i) {
    const auto picture = scene.render({0.7 * i, -0.4 * i});
    const auto &tracks = tracker.process(MovingScene::view(picture), i * second / 25);
    for (const auto &f : tracks.features) {
      EXPECT_EQ(f.state, FeatureState::tracked);
      EXPECT_NEAR(f.x, (f.id == 0 ? 160 : 90.5) + 0.7 * i, 0.3);
      EXPECT_NEAR(f.y, (f.id == 0 ? 120 : 70.25) - 0.4 * i, 0.3);
    }
  }
}

TEST(LucasKanade, IsOutForGoodOnceOverTheEdge) {
  NoExecutor none;
  const MovingScene scene;
  Tracker tracker(lk({{314, 120}}), make_algorithm(lk({{314, 120}}), none));
  FeatureState state{};
  for (int i = 0; i <= 20; ++i)
    state = tracker.process(MovingScene::view(scene.render({0.8 * i, 0})), i * second / 25).features.at(0).state;
  EXPECT_EQ(state, FeatureState::out);
  for (int i = 0; i <= 5; ++i)
    state = tracker.process(MovingScene::view(scene.render({0, 0})), (21 + i) * second / 25).features.at(0).state;
  EXPECT_EQ(state, FeatureState::out);
}

TEST(LucasKanade, NeverFindsALostPointAgain) {
  NoExecutor none;
  const MovingScene scene;
  Tracker tracker(lk({{160, 120}}), make_algorithm(lk({{160, 120}}), none));
  const auto picture = scene.render({0, 0});
  const cv::Mat flat(240, 320, CV_8UC3, cv::Scalar(80, 80, 80));
  tracker.process(MovingScene::view(picture), 0);
  EXPECT_EQ(tracker.process(MovingScene::view(flat), second / 25).features.at(0).state, FeatureState::lost);
  EXPECT_EQ(tracker.process(MovingScene::view(picture), 2 * second / 25).features.at(0).state, FeatureState::lost);
  EXPECT_EQ(tracker.process(MovingScene::view(picture), 3 * second / 25).features.at(0).state, FeatureState::lost);
}

/// 48 points, 30 px apart, 45 px or more from the edges.
std::vector<cv::Point2d> grid() {
  std::vector<cv::Point2d> points;
  for (int y = 45; y <= 195; y += 30)
    for (int x = 45; x <= 255; x += 30) points.emplace_back(x, y);
  return points;
}

/// How far each claimed point of the grid is from its true position after all frames, in pixels.
std::vector<double> errors_after(int frames, cv::Point2d truth, const std::function<cv::Mat(int)> &frame) {
  NoExecutor none;
  const auto points = grid();
  Tracker tracker(lk(points), make_algorithm(lk(points), none));
  std::vector<double> errors;
  for (int i = 0; i <= frames; ++i) {
    const cv::Mat picture = frame(i);
    const auto &tracks = tracker.process(MovingScene::view(picture), i * second / 25);
    if (i < frames) continue;
    for (const auto &f : tracks.features)
      if (f.state == FeatureState::tracked) errors.push_back(cv::norm(cv::Point2d(f.x, f.y) - points[f.id] - truth));
  }
  return errors;
}

double rms(const std::vector<double> &errors) {
  return cv::norm(errors) / std::sqrt(static_cast<double>(errors.size()));
}

/// How many claimed points are within 5 px.
std::ptrdiff_t near(const std::vector<double> &errors) {
  return std::count_if(errors.begin(), errors.end(), [](double error) { return error <= 5; });
}

// A still scene with the noise of a dark picture. Each new template is off the previous one by a fraction of a pixel.
// Independent offsets add up with the root of their number; from the first frame straight to the last there is only
// one.
TEST(LucasKanade, DriftsWithEachTemplateUpdate) {
  const cv::Mat still = MovingScene().render({0, 0});
  const auto noisy = [&](int i) {
    cv::Mat noise(still.size(), CV_16SC3), sum;
    cv::RNG rng(static_cast<std::uint64_t>(i) + 1);
    rng.fill(noise, cv::RNG::NORMAL, 0, 8);
    cv::add(still, noise, sum, cv::noArray(), CV_8UC3);
    return sum;
  };
  constexpr int frames = 100;
  const auto chained = errors_after(frames, {0, 0}, noisy);
  const auto straight = errors_after(1, {0, 0}, [&](int i) { return noisy(i * frames); });
  EXPECT_EQ(straight.size(), grid().size());
  EXPECT_LT(rms(straight), 0.6);
  EXPECT_GT(rms(chained), 3 * rms(straight));
  EXPECT_GT(rms(chained), 1.5 * rms(errors_after(frames / 4, {0, 0}, noisy)));
}

// LK assumes constant brightness: light that dims by a fifth between two frames looks like motion along the gradients.
TEST(LucasKanade, MistakesAChangeOfLightForMotion) {
  const cv::Mat still = MovingScene().render({0, 0});
  const auto dimmed_to = [&](double gain) {
    return errors_after(1, {0, 0}, [&](int i) { return i ? cv::Mat(still * gain) : still; });
  };
  EXPECT_EQ(near(dimmed_to(1)), 48);
  EXPECT_LT(near(dimmed_to(0.8)), 48 / 2);
}

// At the pyramid's top, an eighth of the size, 36 px are still 4.5: more than the width of the blobs there. The same
// path at 3 px a frame does no harm.
TEST(LucasKanade, LosesMotionBeyondThePyramid) {
  const MovingScene scene;
  const auto moved = [&](int frames, cv::Point2d step) {
    return near(errors_after(frames, frames * step, [&](int i) { return scene.render(i * step); }));
  };
  EXPECT_EQ(moved(1, {9, 4.5}), 48);
  EXPECT_EQ(moved(12, {3, 1.5}), 48);
  EXPECT_LT(moved(1, {36, 18}), 48 / 2);
}

}  // namespace
}  // namespace csd
