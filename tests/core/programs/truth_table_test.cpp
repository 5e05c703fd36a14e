// SPDX-License-Identifier: LGPL-2.1-or-later
#include "programs/truth_table.h"

#include <gmock/gmock.h>

#include "programs/file.h"

namespace csd::programs {
namespace {

using score::Presence;
using testing::ElementsAre;

TEST(TruthTable, SortsAndFillsGaps) {
  TruthTable table("truth");
  table.add(9, 90, 5, {Presence::visible, {1, 2}}, 1);
  table.add(4, 40, 8, {Presence::out, {3, 4}}, 2);
  table.add(6, 60, 8, {Presence::unlabelled, {0, 0}}, 3);
  const score::Truth truth = table.take();
  EXPECT_THAT(truth.ids, ElementsAre(5u, 8u));
  ASSERT_EQ(truth.frames.size(), 2u);
  EXPECT_EQ(truth.frames[0].frame, 4u);
  EXPECT_EQ(truth.frames[0].pts, 40);
  EXPECT_EQ(truth.frames[0].line, 2u);
  EXPECT_EQ(truth.frames[0].points[0].presence, Presence::unlabelled);
  EXPECT_EQ(truth.frames[0].points[1].presence, Presence::out);
  EXPECT_EQ(truth.frames[1].points[0].position, cv::Point2d(1, 2));
}

TEST(TruthTable, RefusesDuplicatesAndChanges) {
  TruthTable table("truth");
  table.add(9, no_time, 5, {Presence::visible, {1, 2}}, 1);
  const auto again = [&] { table.add(9, no_time, 5, {Presence::visible, {1, 2}}, 7); };
  EXPECT_EQ(input_error("truth", again), ":7: feature 5 a second time in frame 9");
  table.size(640, 480, 1);
  table.size(640, 480, 2);
  EXPECT_EQ(input_error("truth", [&] { table.size(640, 360, 3); }), ":3: the picture's size changes");
  EXPECT_EQ(input_error("truth", [&] { TruthTable("truth").take(); }), ": labels nothing");
}

}  // namespace
}  // namespace csd::programs
