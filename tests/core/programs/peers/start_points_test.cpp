// SPDX-License-Identifier: LGPL-2.1-or-later
#include "programs/peers/start_points.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <cstdio>
#include <fstream>
#include <stdexcept>

namespace csd::peers {
namespace {

/// A file; the destructor removes it.
struct File {
  explicit File(const std::string &content) : name(testing::TempDir() + "start_points." + std::to_string(getpid())) {
    std::ofstream(name) << content;
  }
  ~File() { std::remove(name.c_str()); }
  std::string name;
};

std::string message_of(const std::string &content) {
  const File file(content);
  try {
    read_start_points(file.name);
  } catch (const std::runtime_error &e) {
    const std::string what = e.what();
    EXPECT_EQ(what.compare(0, file.name.size(), file.name), 0) << what;
    return what.substr(file.name.size());
  }
  return "";
}

TEST(StartPoints, AreReadFromText) {
  const auto p = read_start_points("10,20; 30.5,-4;");
  EXPECT_EQ(p.ids, (std::vector<FeatureId>{0, 1}));
  EXPECT_EQ(p.positions, (std::vector<cv::Point2d>{{10, 20}, {30.5, -4}}));
  EXPECT_THROW(read_start_points("10,20;x"), std::runtime_error);
  EXPECT_THROW(read_start_points("missing.jsonl"), std::runtime_error);
  EXPECT_THROW(read_start_points(";"), std::runtime_error);
}

TEST(StartPoints, AreTheVisibleOnesInTheFirstLineOfJson) {
  const File file(
      R"({"schema":1,"role":"track","frame":0,"width":64,"height":48,"features":[{"id":3,"x":1.5,"y":2,"state":"tracked","confidence":1},)"
      R"({"id":4,"x":9,"y":9,"state":"occluded","confidence":0},)"
      R"({"id":7,"x":5,"y":6.25,"state":"learning","confidence":0.5}]})"
      "\n"
      R"({"schema":1,"role":"track","frame":1,"width":64,"height":48,"features":[]})"
      "\n");
  const auto p = read_start_points(file.name);
  EXPECT_EQ(p.ids, (std::vector<FeatureId>{3, 7}));
  EXPECT_EQ(p.positions, (std::vector<cv::Point2d>{{1.5, 2}, {5, 6.25}}));
  const File truth(
      R"({"schema":1,"role":"truth","frame":0,"width":64,"height":48,"features":[{"id":2,"x":1,"y":2,"state":"occluded","confidence":1},)"
      R"({"id":8,"x":3,"y":4,"state":"tracked","confidence":1}]})"
      "\n");
  EXPECT_EQ(read_start_points(truth.name).ids, std::vector<FeatureId>{8});
}

TEST(StartPoints, AreTheVisibleOnesInFrame0OfCsv) {
  const File by_hand("frame,id,x,y,visible\r\n0,1,10,20.5,1\r\n1,1,11,20,1\r\n0,2,30,40,0\r\n0,5,50,60,1\r\n0,6,5");
  const auto p = read_start_points(by_hand.name);
  EXPECT_EQ(p.ids, (std::vector<FeatureId>{1, 5}));
  EXPECT_EQ(p.positions, (std::vector<cv::Point2d>{{10, 20.5}, {50, 60}}));
  const File tracks(
      "frame,pts,stream_time,id,x,y,state,confidence,fresh\n0,0,0,2,1.000,2.000,tracked,1.000,true\n"
      "0,0,0,3,4.000,5.000,lost,0.000,true\n");
  EXPECT_EQ(read_start_points(tracks.name).ids, std::vector<FeatureId>{2});
}

TEST(StartPoints, ErrorsSayWhatIsWrongAndWhere) {
  EXPECT_EQ(message_of("{\"schema\":1,\"role\":\"track\",\"frame\":5,\"width\":64,\"height\":48,\"features\":[]}\n"),
            ": has no frame 0");
  EXPECT_EQ(message_of("{\"schema\":1,\"role\":\"track\",\"frame\":null,\"features\":[]}\n"), ": has no frame 0");
  EXPECT_EQ(message_of("{\"schema\":1,\"role\":\"track\",\"frame\":0,\"width\":64,\"height\":48,\"features\":[]}\n"),
            ": no visible points in the first frame");
  EXPECT_EQ(message_of("frame,id,x,y,visible\n3,1,2,3,1\n"), ": has no frame 0");
  EXPECT_EQ(message_of("frame,id,x,y,visible\n0,1,2,3,0\n"), ": no visible points in the first frame");
  EXPECT_EQ(message_of("frame,id,x,y,visible\n0,1,2,y,1\n").substr(0, 3), ":2:") << "as csd-score's readers report it";
}

TEST(StartPoints, AreThinnedEvenly) {
  StartPoints all;
  for (FeatureId id = 0; id < 10; ++id) {
    all.ids.push_back(id);
    all.positions.emplace_back(id, 2.0 * id);
  }
  const auto three = thinned(all, 3);
  EXPECT_EQ(three.ids, (std::vector<FeatureId>{0, 3, 6}));
  EXPECT_EQ(three.positions[2], cv::Point2d(6, 12));
  EXPECT_EQ(thinned(all, 0).ids, all.ids);
  EXPECT_EQ(thinned(all, 10).ids, all.ids);
  EXPECT_EQ(thinned(all, 99).ids, all.ids);
}

}  // namespace
}  // namespace csd::peers
