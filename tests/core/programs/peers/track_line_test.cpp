// SPDX-License-Identifier: LGPL-2.1-or-later
#include "programs/peers/track_line.h"

#include <gtest/gtest.h>

#include <array>

namespace csd::peers {
namespace {

// docs/metadata.md
TEST(TrackLine, MatchesCsdtrackencs) {
  Picture picture;
  picture.bgr.create(48, 64, CV_8UC3);
  picture.pts = 480000000;
  picture.duration = 40000000;
  picture.running_time = 400000000;
  picture.stream_time = 440000000;
  const std::array<FeatureId, 3> ids{0, 2, 9};
  const std::array<Report, 3> reports{Report{{31.2, 18.7506}, true}, Report{{5, 6}, false}, Report{{63.6, 6}, true}};
  EXPECT_EQ(track_line("kcf", 12, picture, ids, reports),
            R"({"schema":1,"source":"csd-peers","role":"track","algorithm":"kcf","frame":12,"pts":480000000,)"
            R"("duration":40000000,"running_time":400000000,"stream_time":440000000,"reference":null,"width":64,)"
            R"("height":48,"features":[{"id":0,"x":31.200,"y":18.751,"state":"tracked","confidence":1.000},)"
            R"({"id":2,"x":5.000,"y":6.000,"state":"lost","confidence":0.000},)"
            R"({"id":9,"x":63.600,"y":6.000,"state":"out","confidence":0.000}]})"
            "\n");
}

TEST(TrackLine, WritesNullForUnknownTimes) {
  Picture picture;
  picture.bgr.create(48, 64, CV_8UC3);
  const auto line = track_line("still", 0, picture, {}, {});
  EXPECT_NE(line.find(R"("pts":null,"duration":null,"running_time":null,"stream_time":null,)"), std::string::npos);
  EXPECT_NE(line.find(R"("features":[]})"), std::string::npos);
}

}  // namespace
}  // namespace csd::peers
