// SPDX-License-Identifier: LGPL-2.1-or-later
#include "programs/read_csv.h"

#include <gmock/gmock.h>

#include "programs/input_text.h"

namespace csd::programs {
namespace {

using score::Presence;
using testing::ElementsAre;
using testing::HasSubstr;

const std::string truth_header = "frame,id,x,y,visible\n";
const std::string tracks_header = "frame,pts,stream_time,id,x,y,state,confidence,fresh\n";

TEST(TruthCsv, AcceptsRowsInAnyOrder) {
  const auto truth = read<score::Truth>(truth_header + "50,7,3.5,4,0\n0,7,1,-2.25,1\n50,2,,,0\n0,2,9,9,1\n");
  EXPECT_THAT(truth.ids, ElementsAre(2u, 7u));
  ASSERT_EQ(truth.frames.size(), 2u);
  EXPECT_EQ(truth.frames[0].frame, 0u);
  EXPECT_EQ(truth.frames[0].line, 3u);
  EXPECT_EQ(truth.frames[0].pts, no_time);
  EXPECT_EQ(truth.frames[0].points[1].presence, Presence::visible);
  EXPECT_EQ(truth.frames[0].points[1].position, cv::Point2d(1, -2.25));
  EXPECT_EQ(truth.frames[1].frame, 50u);
  EXPECT_EQ(truth.frames[1].points[1].presence, Presence::hidden);
  EXPECT_EQ(truth.frames[1].points[1].position, cv::Point2d(3.5, 4));
  EXPECT_TRUE(std::isnan(truth.frames[1].points[0].position.x)) << "hidden at an unknown place";
}

TEST(TruthCsv, UncertainAndMissingPointsAreNotLabelled) {
  const auto truth = read<score::Truth>(truth_header + "0,0,1,1,1\n0,1,1,1,1\n1,0,1,1,2\n2,1,1,1,1\n");
  ASSERT_EQ(truth.frames.size(), 2u) << "nothing is labelled in frame 1";
  EXPECT_EQ(truth.frames[1].frame, 2u);
  EXPECT_EQ(truth.frames[1].points[0].presence, Presence::unlabelled);
}

TEST(TruthCsv, AcceptsOtherColumnsQuotesAndWindowsLines) {
  const auto truth =
      read<score::Truth>("\xef\xbb\xbf\"visible\",\"who\",\"y\",\"x\",\"id\",\"frame\"\r\n1,\"me\",2,1,0,4\r\n");
  EXPECT_EQ(truth.frames.at(0).frame, 4u);
  EXPECT_EQ(truth.frames[0].points[0].position, cv::Point2d(1, 2));
}

TEST(TruthCsv, NamesEachDefect) {
  EXPECT_EQ(error_of(truth_header + "0,0,1,1,1\n0,1,x,1,1\n"), ":3: 'x' is no number (x)");
  EXPECT_EQ(error_of(truth_header + "0,0,1,,1\n"), ":2: '' is no number (y)");
  EXPECT_EQ(error_of(truth_header + "0,0,nan,1,1\n"), ":2: 'nan' is no number (x)");
  EXPECT_EQ(error_of(truth_header + "-1,0,1,1,1\n"), ":2: '-1' is no whole number from 0 (frame)");
  EXPECT_EQ(error_of(truth_header + "0,0.5,1,1,1\n"), ":2: '0.5' is no whole number from 0 (id)");
  EXPECT_EQ(error_of(truth_header + "0,0,1,1,yes\n"), ":2: visible is 1, 0 or 2 (uncertain), not 'yes'");
  EXPECT_EQ(error_of(truth_header + "0,0,1,1\n"), ":2: has 4 fields, the header has 5");
  EXPECT_EQ(error_of(truth_header + "3,5,1,1,1\n3,5,1,1,1\n"), ":3: feature 5 a second time in frame 3");
  EXPECT_EQ(error_of("frame,x,y,visible\n0,1,1,1\n"), ":1: has no column 'id'");
  EXPECT_EQ(error_of(truth_header), ": labels nothing");
  EXPECT_EQ(error_of(truth_header + "0,0,1,1,2\n"), ": labels nothing");
}

TEST(TracksCsv, ReadsWhatCsdtrackencWrites) {
  const auto tracks = read<score::Recording>(tracks_header +
                                             "12,480000000,470000000,0,311.204,187.512,tracked,0.931,true\n"
                                             "12,480000000,480000000,4,1.000,2.000,ended,0.000,false\n" +
                                             tracks_header + "14,,,0,312.000,188.000,learning,1.000,true\n");
  EXPECT_TRUE(tracks.sparse);
  ASSERT_EQ(tracks.frames.size(), 2u);
  EXPECT_EQ(tracks.frames[0].frame, 12u);
  EXPECT_EQ(tracks.frames[0].pts, 480000000);
  EXPECT_EQ(tracks.frames[0].stream_time, 470000000);
  EXPECT_EQ(tracks.frames[1].stream_time, no_time);
  EXPECT_EQ(tracks.frames[0].line, 2u);
  ASSERT_EQ(tracks.frames[0].features.size(), 2u);
  EXPECT_EQ(tracks.frames[0].features[0].x, 311.204);
  EXPECT_EQ(tracks.frames[0].features[0].confidence, .931);
  EXPECT_EQ(tracks.frames[0].features[1].id, 4u);
  EXPECT_EQ(tracks.frames[0].features[1].state, FeatureState::ended);
  EXPECT_EQ(tracks.frames[1].pts, no_time);
  EXPECT_EQ(tracks.frames[1].features[0].state, FeatureState::learning);
}

TEST(TracksCsv, DropsATornLastLineWithANote) {
  std::vector<std::string> notes;
  const auto tracks =
      read<score::Recording>(tracks_header + "0,0,0,0,1,1,tracked,1.000,true\n1,40,40,0,1,1,tracked,1.000,tr", &notes);
  EXPECT_EQ(tracks.frames.size(), 1u);
  EXPECT_THAT(notes, ElementsAre(HasSubstr(":3: the last line has no newline")));
}

TEST(TracksCsv, NotesALastFrameCutBetweenItsRows) {
  std::vector<std::string> notes;
  read<score::Recording>(tracks_header +
                             "0,0,0,0,1,1,tracked,1,true\n0,0,0,1,1,1,tracked,1,true\n"
                             "1,40,40,0,1,1,tracked,1,true\n",
                         &notes);
  EXPECT_THAT(notes, ElementsAre(HasSubstr(":4: from frame 1 on, 1 feature is absent")));
}

TEST(TracksCsv, NamesEachDefect) {
  EXPECT_EQ(error_of(tracks_header + "0,0,0,0,1,1,found,1.000,true\n"), ":2: there is no state 'found'");
  EXPECT_EQ(error_of(tracks_header + "0,0,0,0,1,1,tracked,1.5,true\n"), ":2: a confidence is from 0 to 1");
  EXPECT_EQ(error_of(tracks_header + "0,0,0,1,1,1,tracked,1,true\n0,0,0,1,1,1,tracked,1,true\n"),
            ":3: feature 1 after feature 1");
  EXPECT_EQ(error_of(tracks_header + "1,0,0,1,1,1,tracked,1,true\n0,0,0,1,1,1,tracked,1,true\n"),
            ":3: frame 0 after frame 1");
  EXPECT_EQ(error_of("frame,id,x,y,state\n"), ":1: has no column 'confidence'");
}

TEST(Input, NamesAFileThatIsNeitherJsonNorCsv) {
  EXPECT_EQ(error_of(""), ": is empty");
  EXPECT_EQ(error_of(" \n\n"), ": is empty");
  EXPECT_THAT(error_of("hello\n"), HasSubstr(":1: neither JSON nor a header of CSV"));
  std::vector<std::string> notes;
  EXPECT_EQ(input_error("/nowhere/x", [&] { read_input("/nowhere/x", notes); }),
            ": can't be read: No such file or directory");
}

}  // namespace
}  // namespace csd::programs
