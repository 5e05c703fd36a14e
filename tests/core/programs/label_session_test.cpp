// SPDX-License-Identifier: LGPL-2.1-or-later
#include "programs/label_session.h"

#include <gmock/gmock.h>

#include "programs/file.h"

namespace csd::programs {
namespace {

using Sight = LabelSession::Sight;
using testing::HasSubstr;

LabelSession two_points() {
  LabelSession session(50);
  session.place({1, 2});
  session.place({30.25, 4});
  session.done_choosing();
  return session;
}

TEST(LabelSession, PointsAreChosenThenAskedForInEveryNthFrame) {
  LabelSession session(50);
  EXPECT_FALSE(session.done_choosing()) << "no point yet";
  EXPECT_TRUE(session.choosing());
  session = two_points();
  EXPECT_FALSE(session.choosing());
  EXPECT_EQ(session.points(), 2u);
  EXPECT_EQ(session.frame(), 50u);
  EXPECT_EQ(session.point(), 0u);
  session.place({5, 5});
  EXPECT_EQ(session.frame(), 50u);
  EXPECT_EQ(session.point(), 1u);
  session.skip(Sight::hidden);
  EXPECT_EQ(session.frame(), 100u);
  EXPECT_EQ(session.point(), 0u);
  session.skip(Sight::uncertain);
  EXPECT_EQ(session.csv(),
            "frame,id,x,y,visible\n0,0,1.000,2.000,1\n0,1,30.250,4.000,1\n50,0,5.000,5.000,1\n50,1,,,0\n100,0,,,2\n");
  EXPECT_EQ(session.last_seen(0).position, cv::Point2d(5, 5));
  EXPECT_EQ(session.last_seen(1).position, cv::Point2d(30.25, 4));
}

TEST(LabelSession, UndoGoesBackToTheBeginning) {
  LabelSession session = two_points();
  session.place({5, 5});
  session.place({6, 6});
  EXPECT_EQ(session.frame(), 100u);
  EXPECT_TRUE(session.undo());
  EXPECT_EQ(session.frame(), 50u);
  EXPECT_EQ(session.point(), 1u);
  EXPECT_TRUE(session.undo());
  EXPECT_FALSE(session.choosing());
  EXPECT_TRUE(session.undo());
  EXPECT_TRUE(session.choosing()) << "one undo takes back the end of choosing";
  EXPECT_EQ(session.points(), 2u);
  EXPECT_TRUE(session.undo());
  EXPECT_EQ(session.points(), 1u);
  EXPECT_TRUE(session.undo());
  EXPECT_FALSE(session.undo());
  EXPECT_EQ(session.csv(), "frame,id,x,y,visible\n");
}

TEST(LabelSession, ResumesWhereItWasSaved) {
  const TestFolder folder;
  LabelSession session = two_points();
  session.place({5, 5});
  session.skip(Sight::hidden);
  session.skip(Sight::uncertain);
  const LabelSession again = LabelSession::resume(read_text_file(folder.write("l", session.csv())), 50);
  EXPECT_EQ(again.csv(), session.csv());
  EXPECT_EQ(again.frame(), 100u);
  EXPECT_EQ(again.point(), 1u);
  // A torn line is asked for again.
  const LabelSession torn = LabelSession::resume(read_text_file(folder.write("l", session.csv() + "100,1,3.0")), 50);
  EXPECT_EQ(torn.csv(), session.csv());
  // With frame 0 only, points may still be added.
  const LabelSession chosen =
      LabelSession::resume(read_text_file(folder.write("l", "frame,id,x,y,visible\n0,0,1.000,2.000,1\n")), 50);
  EXPECT_TRUE(chosen.choosing());
  EXPECT_EQ(chosen.points(), 1u);
}

TEST(LabelSession, RefusesOtherLabels) {
  const TestFolder folder;
  const auto error_of = [&](const std::string &rows) {
    const std::string file = folder.write("l", "frame,id,x,y,visible\n" + rows);
    return input_error(file, [&] { LabelSession::resume(read_text_file(file), 50); });
  };
  EXPECT_THAT(error_of("0,0,1,1,1\n25,0,1,1,1\n"), HasSubstr(":3: is not what labelling every 50 frames wrote"));
  EXPECT_THAT(error_of("0,1,1,1,1\n"), HasSubstr(":2: is not what"));
  EXPECT_THAT(error_of("0,0,1,1,0\n"), HasSubstr(":2: is not what")) << "a chosen point is visible";
  EXPECT_THAT(error_of("0,0,1,1,1\n0,1,1,1,1\n50,1,1,1,1\n"), HasSubstr("feature 0 of frame 50 comes here"));
  EXPECT_THAT(error_of("50,0,1,1,1\n"), HasSubstr(":2: is not what"));
}

}  // namespace
}  // namespace csd::programs
