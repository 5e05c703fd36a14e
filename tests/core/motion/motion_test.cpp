// SPDX-License-Identifier: LGPL-2.1-or-later
#include "motion/motion.h"

#include <gtest/gtest.h>

#include "algorithms/make_algorithm.h"
#include "signals.h"
#include "sim/camera.h"
#include "sim/simulator.h"
#include "sim/surface.h"
#include "track/tracker.h"

namespace csd::motion {
namespace {

/// Runs learning jobs at once, so that a tracker always does the same.
struct Immediately : Executor {
  void post(std::function<void()> job) override { job(); }
};

const SceneRhythm *scene_rhythm(const Motion &motion, double frequency) {
  for (const SceneRhythm &one : motion.scene_rhythms)
    if (std::abs(one.rhythm.frequency - frequency) <= .02 * frequency) return &one;
  return nullptr;
}

/// Expects the rates of the simulated tissue, to 2 %, in the scene and in most features.
void expect_rates(const Motion &motion) {
  for (const double rate : {sim::heart_rate, sim::breath_rate}) {
    const SceneRhythm *const one = scene_rhythm(motion, rate);
    ASSERT_TRUE(one) << rate << " Hz";
    EXPECT_LT(one->rhythm.false_alarm, .001);
    EXPECT_GT(one->judged, 0u);
    EXPECT_GE(4 * one->agreeing, 3 * one->judged) << rate << " Hz";
  }
  EXPECT_EQ(motion.scene_rhythms.size(), 2u);
}

sim::Effects effects_of(const char *text) {
  sim::Effects effects;
  effects.set(text);
  return effects;
}

TEST(Motion, FindsTheRatesOfSimulatedTissueInItsTruth) {
  for (const char *const effects : {"heart-strong", "heart-mild,liver=.3", "heart-strong=.5,liver=.5,rotation=.1"})
    for (const std::uint64_t seed : {1, 2, 3}) {
      SCOPED_TRACE(std::string(effects) + ", seed " + std::to_string(seed));
      const sim::Surface surface(effects_of(effects), seed);
      const Series series = series_of_signals(9, 60, .1, 1, [&](std::size_t f, double t) {
        const auto place = surface.place(80. * static_cast<double>(f % 3) - 80, 80. * static_cast<double>(f / 3) - 80);
        const cv::Point3d p = sim::camera_at(t, effects_of(effects), seed, {640, 480}).project(surface.at(t).at(place));
        return cv::Point2d(p.x, p.y);
      });
      expect_rates(analyse(series));
    }
}

TEST(Motion, FindsTheRatesOfSimulatedTissueInTracksOfCsd) {
  sim::SimSettings settings;
  settings.effects = effects_of("heart-strong=.5,liver=.2,noise");
  settings.size = {192, 144};
  sim::Simulator simulator(settings);
  Settings tracking;
  tracking.max_features = 6;
  tracking.learn_synchronously = true;
  Immediately now;
  Tracker tracker(tracking, make_algorithm(tracking, now));
  score::Recording tracks;
  cv::Mat picture;
  for (std::uint64_t n = 0; n < 1000; ++n) {
    simulator.render(n, picture);
    FrameView view;
    view.width = picture.cols;
    view.height = view.rows = picture.rows;
    view.model = ColourModel::rgb;
    for (std::size_t i = 0; i < 3; ++i)
      view.component[i] = {picture.data + 2 - i, static_cast<std::ptrdiff_t>(picture.step), 3, 1, 0, 0, 0};
    score::TrackFrame frame;
    frame.frame = n;
    frame.pts = static_cast<std::int64_t>(n) * second / 25;
    frame.features = tracker.process(view, frame.pts, second / 25).features;
    tracks.frames.push_back(std::move(frame));
  }
  const Motion motion = analyse(series_of(tracks));
  EXPECT_GE(motion.series.paths.size(), 4u);
  expect_rates(motion);
}

TEST(Motion, CountsTheFeaturesThatAgree) {
  // Of ten features seven beat and three are still. One more is claimed for too short a time.
  const Series series = series_of_signals(
      11, 40, .2, 3, [](std::size_t f, double t) { return cv::Point2d(f < 7 ? 2 * sine(1.2 * t) : 0, 0); },
      [](std::size_t f, double t) { return f < 10 || t < 3; });
  const Motion motion = analyse(series);
  ASSERT_EQ(motion.scene_rhythms.size(), 1u);
  EXPECT_EQ(motion.scene_rhythms[0].agreeing, 7u);
  EXPECT_EQ(motion.scene_rhythms[0].judged, 10u);
  ASSERT_EQ(motion.rhythms.size(), 11u);
  EXPECT_EQ(motion.rhythms[0].rhythms.size(), 1u);
  EXPECT_EQ(motion.rhythms[9].rhythms.size(), 0u);
  EXPECT_EQ(motion.scene.displacement.size(), motion.series.times.size());
}

TEST(Motion, AFeaturesHarmonicAgreesToo) {
  // Two features move at half the rate of the others, but not as a sine.
  const Series series = series_of_signals(8, 40, .1, 4, [](std::size_t f, double t) {
    return cv::Point2d(f < 2 ? 3 * sine(.6 * t) + 1.5 * sine(1.2 * t) : 2 * sine(1.2 * t), 0);
  });
  const Motion motion = analyse(series);
  ASSERT_GE(motion.scene_rhythms.size(), 1u);
  EXPECT_NEAR(motion.scene_rhythms[0].rhythm.frequency, 1.2, .01);
  EXPECT_EQ(motion.scene_rhythms[0].agreeing, 8u);
}

}  // namespace
}  // namespace csd::motion
