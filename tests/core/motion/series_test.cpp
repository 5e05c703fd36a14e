// SPDX-License-Identifier: LGPL-2.1-or-later
#include "motion/series.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace csd::motion {
namespace {

using score::Recording;
using testing::ElementsAre;
using testing::HasSubstr;

constexpr std::int64_t ms = 1000000;

/// Adds a frame. Features are {id, x, y}, and claimed unless another state is given.
void add(Recording &tracks, std::int64_t pts, std::vector<Feature> features) {
  score::TrackFrame frame;
  frame.frame = tracks.frames.size();
  frame.pts = pts;
  frame.line = tracks.frames.size() + 1;
  frame.features = std::move(features);
  tracks.frames.push_back(std::move(frame));
}

Feature at(FeatureId id, double x, double y, FeatureState state = FeatureState::tracked) {
  return {id, x, y, state, 1, true};
}

Recording recording() {
  Recording tracks;
  tracks.file = "t.jsonl";
  return tracks;
}

std::string error_of(const Recording &tracks, const Span &span = {}) {
  try {
    series_of(tracks, span);
  } catch (const score::InputError &error) {
    return error.what();
  }
  return "no error";
}

TEST(Series, HoldsTheClaims) {
  Recording tracks = recording();
  add(tracks, 1000 * ms, {at(3, 10, 20, FeatureState::learning), at(7, 1, 2, FeatureState::occluded)});
  add(tracks, 1040 * ms, {at(3, 11, 22, FeatureState::lost), at(7, 3, 4)});
  add(tracks, 1080 * ms, {at(3, 12, 24), at(8, 0, 0, FeatureState::out), at(9, 0, 0, FeatureState::ended)});
  add(tracks, 1140 * ms, {});
  const Series series = series_of(tracks);
  EXPECT_THAT(series.times, ElementsAre(1, 1.04, 1.08, 1.14));
  EXPECT_THAT(series.frames, ElementsAre(0, 1, 2, 3));
  EXPECT_NEAR(series.interval, .04, 1e-12);
  ASSERT_EQ(series.paths.size(), 2u);
  EXPECT_EQ(series.paths[0].id, 3u);
  EXPECT_THAT(series.paths[0].frames, ElementsAre(0, 2));
  EXPECT_THAT(series.paths[0].positions, ElementsAre(cv::Point2d(10, 20), cv::Point2d(12, 24)));
  EXPECT_THAT(series.paths[1].frames, ElementsAre(1));
  const ClaimsByFrame claims(series);
  ASSERT_EQ(claims.at(2).size(), 1u);
  EXPECT_EQ(claims.at(2)[0].path, 0u);
  EXPECT_EQ(claims.at(2)[0].place, 1u);
  EXPECT_TRUE(claims.at(3).empty());
}

TEST(Series, IsCutToASpan) {
  Recording tracks = recording();
  for (int i = 0; i < 10; ++i) add(tracks, i * 100 * ms, {at(0, i, 0)});
  const Series series = series_of(tracks, {.2, .5, 0});
  EXPECT_THAT(series.frames, ElementsAre(2, 3, 4, 5));
  EXPECT_EQ(series.paths[0].start(), cv::Point2d(2, 0));
  EXPECT_THAT(error_of(tracks, {.91, std::nullopt, 0}), HasSubstr("no frame in that span"));
}

TEST(Series, UsesTheFrameRateWhereThereAreNoTimes) {
  Recording tracks = recording();
  for (int i = 0; i < 3; ++i) add(tracks, no_time, {at(0, 0, 0)});
  EXPECT_THAT(error_of(tracks), HasSubstr("has no times"));
  EXPECT_THAT(series_of(tracks, {{}, {}, 50}).times, ElementsAre(0, .02, .04));
  tracks.frames[1].pts = 7000 * ms;  // only this frame has a time, so only it counts
  EXPECT_THAT(series_of(tracks, {{}, {}, 50}).times, ElementsAre(7));
}

TEST(Series, GoesByTheFirstClockThatNeverGoesBack) {
  Recording tracks = recording();
  for (const std::int64_t pts : {0, 40, 20}) add(tracks, pts * ms, {at(0, 0, 0)});
  const auto set = [&](std::int64_t score::TrackFrame::*clock, std::initializer_list<std::int64_t> times) {
    std::size_t i = 0;
    for (const std::int64_t time : times) tracks.frames[i++].*clock = time * ms;
  };
  set(&score::TrackFrame::running_time, {100, 140, 180});
  EXPECT_THAT(series_of(tracks).times, ElementsAre(.1, .14, .18)) << "there is no stream time";
  set(&score::TrackFrame::stream_time, {0, 40, 30});
  EXPECT_EQ(series_of(tracks).clock, "running_time");
  set(&score::TrackFrame::stream_time, {1000, 1040, 1080});
  EXPECT_THAT(series_of(tracks).times, ElementsAre(1, 1.04, 1.08));
  EXPECT_EQ(series_of(tracks).clock, "stream_time");
  set(&score::TrackFrame::pts, {0, 40, 40});
  EXPECT_THAT(series_of(tracks).times, ElementsAre(0, .04, .04));
  EXPECT_EQ(series_of(tracks).clock, "pts");
}

TEST(Series, HasAnIntervalAlsoWhereMostFramesShareTheirTimes) {
  Recording tracks = recording();
  for (int i = 0; i < 9; ++i) add(tracks, i / 3 * 120 * ms, {at(0, 0, 0)});
  EXPECT_NEAR(series_of(tracks).interval, .03, 1e-12);
}

TEST(Series, HasOnlyFramesOfTheFirstPicturesSize) {
  Recording tracks = recording();
  for (int i = 0; i < 5; ++i) {
    add(tracks, i * 40 * ms, {at(0, i, 0)});
    tracks.frames[i].width = i == 1 || i == 3 ? 320 : 640;
    tracks.frames[i].height = i == 3 ? 200 : 480;
  }
  tracks.width = 640;
  tracks.height = 480;
  const Series series = series_of(tracks);
  EXPECT_THAT(series.frames, ElementsAre(0, 2, 4));
  EXPECT_THAT(series.paths[0].positions, ElementsAre(cv::Point2d(0, 0), cv::Point2d(2, 0), cv::Point2d(4, 0)));
  EXPECT_EQ(series.left_out, 2u);
  EXPECT_EQ(series.other_width, 320);
  EXPECT_EQ(series.other_height, 480);
  EXPECT_EQ(series.other_line, 2u);
}

TEST(Series, RefusesTimesThatGoBackAndTracksWithoutClaims) {
  Recording tracks = recording();
  add(tracks, 40 * ms, {at(0, 0, 0)});
  add(tracks, 39 * ms, {at(0, 0, 0)});
  EXPECT_THAT(error_of(tracks), HasSubstr("t.jsonl:2: the time goes back (frame 1)"));
  tracks.frames.pop_back();
  EXPECT_EQ(error_of(tracks), "no error");
  tracks.frames[0].features[0].y = -1e300;
  EXPECT_THAT(error_of(tracks), HasSubstr("t.jsonl:1: feature 0 is claimed far outside"));
  tracks.frames[0].features[0].state = FeatureState::lost;
  EXPECT_THAT(error_of(tracks), HasSubstr("claims no position"));
  tracks.frames.clear();
  EXPECT_NE(error_of(tracks), "no error");
}

/// A path given by x; y is 10 x.
Series one_path(std::vector<double> times, std::vector<std::size_t> frames, const std::vector<double> &x) {
  Series series;
  series.times = std::move(times);
  series.frames.resize(series.times.size());
  series.interval = 1;
  Path path;
  path.frames = std::move(frames);
  for (const double value : x) path.positions.emplace_back(value, 10 * value);
  series.paths.push_back(std::move(path));
  return series;
}

TEST(Velocity, IsExactForAParabolaAlsoAtUnevenTimes) {
  // x = t² + 3 t: 2 t + 3.
  const Series series = one_path({0, 1, 1.5, 3.5}, {0, 1, 2, 3}, {0, 4, 6.75, 22.75});
  const auto v = velocities(series, series.paths[0]);
  EXPECT_NEAR(v[1].x, 5, 1e-12);
  EXPECT_NEAR(v[1].y, 50, 1e-11);
  EXPECT_NEAR(v[2].x, 6, 1e-12);
  EXPECT_NEAR(v[0].x, 4, 1e-12) << "by the next frame";
  EXPECT_NEAR(v[3].x, 8, 1e-12) << "by the previous frame";
}

TEST(Velocity, NeedsTimeBetweenFrames) {
  const Series series = one_path({0, 1, 1, 3}, {0, 1, 2, 3}, {0, 2, 4, 10});
  const auto v = velocities(series, series.paths[0]);
  EXPECT_THAT(std::vector<double>({v[0].x, v[1].x, v[2].x, v[3].x}), ElementsAre(2, 2, 3, 3));
}

TEST(Velocity, DoesNotReachOverGaps) {
  // Frame 2 is not claimed. From 4 to 5 there are three intervals.
  const Series series = one_path({0, 1, 2, 3, 4, 7, 8}, {0, 1, 3, 4, 5, 6}, {0, 2, 100, 101, 200, 207});
  const auto v = velocities(series, series.paths[0]);
  EXPECT_THAT(std::vector<double>({v[0].x, v[1].x, v[2].x, v[3].x, v[4].x, v[5].x}), ElementsAre(2, 2, 1, 1, 7, 7));
  const Series alone = one_path({0, 1, 2}, {1}, {5});
  EXPECT_FALSE(known(velocities(alone, alone.paths[0])[0]));
}

TEST(Scene, MovesByTheMedianStep) {
  Recording tracks = recording();
  add(tracks, 0, {at(0, 10, 0), at(1, 20, 0), at(2, 30, 0)});
  add(tracks, 1000 * ms, {at(0, 11, 1), at(1, 22, 2), at(2, 90, 90)});  // steps 1, 2, 60: 2
  add(tracks, 2000 * ms, {at(1, 23, 3), at(3, 500, 500)});              // 1; feature 3 begins, and moves nothing
  add(tracks, 3000 * ms, {});
  add(tracks, 4000 * ms, {at(1, 50, 50)});  // no frame before shows where it came from
  add(tracks, 5000 * ms, {at(1, 54, 50)});
  const SceneMotion scene = scene_motion(series_of(tracks));
  EXPECT_THAT(scene.features, ElementsAre(3, 3, 2, 0, 1, 1));
  EXPECT_EQ(scene.displacement[0], cv::Point2d(0, 0));
  EXPECT_EQ(scene.displacement[1], cv::Point2d(2, 2));
  EXPECT_EQ(scene.displacement[2], cv::Point2d(3, 3));
  EXPECT_FALSE(known(scene.displacement[3]));
  EXPECT_EQ(scene.displacement[4], cv::Point2d(3, 3));
  EXPECT_EQ(scene.displacement[5], cv::Point2d(7, 3));
  EXPECT_EQ(scene.velocity[0], cv::Point2d(2, 2));
  EXPECT_EQ(scene.velocity[1], cv::Point2d(1.5, 1.5)) << "of 1, 1.5 and 60";
  EXPECT_FALSE(known(scene.velocity[3]));
  EXPECT_EQ(scene.velocity[5], cv::Point2d(4, 0));
}

}  // namespace
}  // namespace csd::motion
