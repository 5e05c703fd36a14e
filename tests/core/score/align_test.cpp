// SPDX-License-Identifier: LGPL-2.1-or-later
#include "score/align.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace csd::score {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

constexpr std::int64_t step = 40000000;

/// One feature, id 3, at x = 10·frame. Frame n is line n + 1.
Truth truth_of(std::vector<std::uint64_t> frames, bool timed = true) {
  Truth truth;
  truth.file = "truth.csv";
  truth.width = 640;
  truth.height = 480;
  truth.ids = {3};
  for (const std::uint64_t frame : frames)
    truth.frames.push_back({frame,
                            timed ? static_cast<std::int64_t>(frame) * step : no_time,
                            frame + 1,
                            {{Presence::visible, {10. * static_cast<double>(frame), 0}}}});
  return truth;
}

/// The same, moved one pixel to the right.
Recording tracks_of(std::vector<std::uint64_t> frames, std::int64_t late = 0) {
  Recording tracks;
  tracks.file = "tracks.jsonl";
  for (const std::uint64_t frame : frames)
    tracks.frames.push_back({true,
                             frame,
                             static_cast<std::int64_t>(frame) * step + late,
                             frame + 1,
                             {{3, 10. * static_cast<double>(frame) + 1, 0, FeatureState::tracked, .5, true}}});
  return tracks;
}

std::string error_of(const Truth &truth, const Recording &tracks, const AlignOptions &options = {}) {
  std::vector<std::string> notes;
  try {
    align(truth, tracks, options, notes);
  } catch (const InputError &error) {
    return error.what();
  }
  return "no error";
}

Clip aligned(const Truth &truth, const Recording &tracks, const AlignOptions &options = {}) {
  std::vector<std::string> notes;
  Clip clip = align(truth, tracks, options, notes);
  EXPECT_THAT(notes, IsEmpty());
  return clip;
}

TEST(Align, MatchesLabelledFramesWithReports) {
  const Clip clip = aligned(truth_of({0, 2}), tracks_of({0, 1, 2, 3}));
  ASSERT_EQ(clip.moments.size(), 2u);
  EXPECT_EQ(clip.moments[1].frame, 2u);
  EXPECT_EQ(clip.moments[1].pts, 2 * step);
  const Sample &sample = clip.at(0, 1);
  EXPECT_TRUE(sample.visible() && sample.claimed && sample.reported);
  EXPECT_EQ(sample.dx, 1);
  EXPECT_EQ(sample.dy, 0);
  EXPECT_EQ(sample.confidence, .5);
  EXPECT_EQ(clip.height, 480);
  EXPECT_THAT(clip.starts, ElementsAre(cv::Point2d(0, 0)));
  EXPECT_THAT(clip.ends, ElementsAre(cv::Point2d(20, 0)));
  EXPECT_THAT(clip.reports_last, ElementsAre(cv::Point2d(21, 0)));
}

TEST(Align, PtsDecideWhereTheTruthHasThem) {
  // The tracks count frames from 5, and lag by 19 ms: less than half a frame.
  Recording tracks = tracks_of({0, 1, 2}, step / 2 - 1000000);
  for (TrackFrame &frame : tracks.frames) frame.frame += 5;
  EXPECT_EQ(aligned(truth_of({0, 1, 2}), tracks).at(0, 2).dx, 1);
  tracks = tracks_of({0, 1, 2}, step / 2);
  EXPECT_EQ(error_of(truth_of({2}), tracks), "tracks.jsonl: lacks frame 2 (pts 80000000) of truth.csv:3");
  EXPECT_EQ(aligned(truth_of({2}), tracks, {true, {}, 0, 0}).at(0, 0).dx, 1) << "by frame";
}

TEST(Align, FrameNumbersDecideWhereTheTruthHasNoPts) {
  EXPECT_EQ(aligned(truth_of({1, 2}, false), tracks_of({0, 1, 2}, 12345678)).at(0, 1).dx, 1);
}

TEST(Align, AFrameMissingInTheTracksIsAnError) {
  EXPECT_EQ(error_of(truth_of({0, 1, 2}, false), tracks_of({0, 2})), "tracks.jsonl: lacks frame 1 of truth.csv:2");
  EXPECT_EQ(error_of(truth_of({0, 3}), tracks_of({0, 1, 2})),
            "tracks.jsonl: lacks frame 3 (pts 120000000) of truth.csv:4");
  Recording untimed = tracks_of({0, 1});
  for (TrackFrame &frame : untimed.frames) frame.pts = no_time;
  EXPECT_THAT(error_of(truth_of({0, 1}), untimed), HasSubstr("tracks.jsonl: has no pts, which truth.csv has"));
}

TEST(Align, InCsvAFrameWithoutRowsBeforeTheLastHasNoFeatures) {
  Recording tracks = tracks_of({0, 2});
  tracks.sparse = true;
  for (const bool timed : {true, false}) {
    std::vector<std::string> notes;
    const Clip clip = align(truth_of({0, 1, 2}, timed), tracks, {}, notes);
    EXPECT_FALSE(clip.at(0, 1).reported || clip.at(0, 1).claimed);
    EXPECT_EQ(clip.at(0, 1).dx, 1 - 10) << "at its last report";
    EXPECT_EQ(clip.at(0, 2).dx, 1);
    EXPECT_THAT(notes, ElementsAre(HasSubstr("1 labelled frames have no rows")));
    EXPECT_THAT(error_of(truth_of({0, 3}, timed), tracks), HasSubstr("lacks frame 3")) << "the file may be truncated";
  }
}

TEST(Align, AnUnclaimedFeatureKeepsItsLastReport) {
  Recording tracks = tracks_of({0, 1, 2, 3});
  tracks.frames[1].features[0].state = FeatureState::lost;
  tracks.frames[2].features.clear();
  const Clip clip = aligned(truth_of({0, 1, 2, 3}), tracks);
  EXPECT_TRUE(clip.at(0, 1).reported);
  EXPECT_FALSE(clip.at(0, 1).claimed);
  EXPECT_EQ(clip.at(0, 1).dx, 1);
  EXPECT_FALSE(clip.at(0, 2).reported);
  EXPECT_EQ(clip.at(0, 2).dx, 11 - 20) << "the last report is of frame 1";
  EXPECT_TRUE(clip.at(0, 3).claimed);
}

TEST(Align, BeforeItsFirstReportAFeatureHasNoPosition) {
  Recording tracks = tracks_of({0, 1});
  tracks.frames[0].features.clear();
  EXPECT_TRUE(std::isinf(aligned(truth_of({0, 1}), tracks).at(0, 0).distance()));
}

TEST(Align, AHiddenPointWithoutPositionHasNoError) {
  Truth truth = truth_of({0, 1});
  truth.frames[1].points[0] = {Presence::hidden, {unknown, unknown}};
  const Clip clip = aligned(truth, tracks_of({0, 1}));
  EXPECT_TRUE(clip.at(0, 1).claimed);
  EXPECT_TRUE(std::isinf(clip.at(0, 1).distance()));
}

TEST(Align, SizesMustBeKnownAndAgree) {
  Truth truth = truth_of({0});
  Recording tracks = tracks_of({0});
  tracks.width = 320;
  tracks.height = 240;
  EXPECT_EQ(error_of(truth, tracks), "tracks.jsonl: is of 320x240 pixels, not of 640x480");
  EXPECT_EQ(error_of(truth, tracks_of({0}), {false, {}, 320, 240}), "truth.csv: is of 640x480 pixels, not of 320x240");
  truth.width = truth.height = 0;
  EXPECT_EQ(aligned(truth, tracks).height, 240);
  EXPECT_EQ(aligned(truth, tracks_of({0}), {false, {}, 100, 50}).height, 50);
  EXPECT_THAT(error_of(truth, tracks_of({0})), HasSubstr("says nothing of the picture's size"));
}

TEST(Align, ASizeThatChangesIsAnError) {
  Recording tracks = tracks_of({0, 1, 2});
  tracks.width = 640;
  tracks.height = 480;
  tracks.frames[1].width = 320;
  tracks.frames[1].height = 480;
  EXPECT_EQ(error_of(truth_of({0, 1}), tracks), "tracks.jsonl:2: the picture's size changes");
}

TEST(Align, FeaturesMissingInTheTracksAreAnError) {
  Truth truth = truth_of({0});
  truth.ids = {3, 4};
  truth.frames[0].points.push_back({Presence::visible, {5, 5}});
  EXPECT_EQ(error_of(truth, tracks_of({0})),
            "tracks.jsonl: never mentions feature 4 of truth.csv (--ids scores some features only)");
  EXPECT_THAT(aligned(truth, tracks_of({0}), {false, {3}, 0, 0}).ids, ElementsAre(3u));
  EXPECT_EQ(error_of(truth, tracks_of({0}), {false, {3, 9}, 0, 0}), "truth.csv: has no feature 9");
}

TEST(Align, TheSameFrameTwiceIsAnError) {
  Recording tracks = tracks_of({0, 1, 2});
  tracks.frames[2].frame = 1;
  EXPECT_EQ(error_of(truth_of({0}), tracks), "tracks.jsonl:3: frame 1 a second time, first in line 2");
  tracks = tracks_of({0, 1, 2});
  tracks.frames[2].pts = step;
  EXPECT_EQ(error_of(truth_of({0}), tracks), "tracks.jsonl:3: pts 40000000 a second time, first in line 2");
  Truth truth = truth_of({0, 1});
  truth.frames[1].pts = 1000;
  EXPECT_THAT(error_of(truth, tracks_of({0, 1})), HasSubstr("truth.csv:2: is the same frame as the one before"));
}

TEST(Align, TracksThatGoBackInTimeAreAnError) {
  Recording tracks = tracks_of({0, 1, 2});
  std::swap(tracks.frames[1].pts, tracks.frames[2].pts);
  EXPECT_THAT(error_of(truth_of({0, 1, 2}), tracks), HasSubstr("tracks.jsonl:2: goes back in time"));
}

TEST(Align, NotesTracksThatBeginElsewhere) {
  Truth truth = truth_of({0});
  truth.frames[0].points[0].position = {40, 0};
  std::vector<std::string> notes;
  align(truth, tracks_of({0}), {}, notes);
  EXPECT_THAT(notes, ElementsAre(HasSubstr("begin 39 px (median)")));
}

/// Notes on labels of every tenth frame, one frame late, of a point that oscillates by some pixels, with noise of
/// `noise` px, uniform.
std::vector<std::string> notes_of_late_labels(int late, double noise, std::size_t labels) {
  const auto x = [](std::size_t frame) { return 100 + 20 * std::sin(static_cast<double>(frame) / 4); };
  Recording tracks = tracks_of({});
  for (std::size_t i = 0; i < 10 * labels + 10; ++i)
    tracks.frames.push_back({true, i, no_time, i + 1, {{3, x(i), 50, FeatureState::tracked, .9, true}}});
  Truth truth = truth_of({}, false);
  std::mt19937 random(1);
  for (std::size_t i = 1; i <= labels; ++i) {
    const double error = noise * (static_cast<double>(random()) / 0x1p31 - 1);
    const auto frame = static_cast<std::uint64_t>(static_cast<std::int64_t>(10 * i) + late);
    truth.frames.push_back({frame, no_time, i + 1, {{Presence::visible, {x(10 * i) + error, 50}}}});
  }
  std::vector<std::string> notes;
  align(truth, tracks, {}, notes);
  return notes;
}

TEST(Align, NotesLabelsThatAreOneFrameOff) {
  const auto from_one = ElementsAre(
      "truth.csv: its labels fit the frame before theirs in tracks.jsonl better: are they numbered from 1? The first "
      "frame is 0");
  EXPECT_THAT(notes_of_late_labels(1, 0, 2), from_one);
  EXPECT_THAT(notes_of_late_labels(1, 3, 40), from_one);
  EXPECT_THAT(notes_of_late_labels(-1, 1, 10), ElementsAre(HasSubstr("fit the frame after theirs")));
  for (const double noise : {0., 1., 4., 30.})
    for (const std::size_t labels : {2u, 3u, 10u, 100u})
      EXPECT_THAT(notes_of_late_labels(0, noise, labels), IsEmpty()) << noise << " px, " << labels << " labels";
}

TEST(Align, OfStirOnlyTheEndIsKnown) {
  Truth truth = truth_of({0});
  truth.identified = false;
  truth.end_points = {{70, 0}};
  std::vector<std::string> notes;
  const Clip clip = align(truth, tracks_of({0, 1, 2}), {}, notes);
  EXPECT_TRUE(clip.moments.empty());
  EXPECT_THAT(clip.ends, ElementsAre(cv::Point2d(70, 0)));
  EXPECT_THAT(clip.reports_last, ElementsAre(cv::Point2d(21, 0))) << "from the tracks' last frame";
  EXPECT_THAT(notes, ElementsAre(HasSubstr("compared with the last frame of tracks.jsonl, line 3")));
}

}  // namespace
}  // namespace csd::score
