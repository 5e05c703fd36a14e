// SPDX-License-Identifier: LGPL-2.1-or-later
#include "text/write_line.h"

#include <gtest/gtest.h>

#include <clocale>
#include <limits>
#include <utility>

#include "text/read_line.h"

namespace csd {
namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();

std::string json(const LineHead &head, std::initializer_list<LineFeature> features) {
  std::string out;
  JsonLine line(out, head);
  for (const auto &feature : features) line.add(feature);
  line.end();
  return out;
}

// docs/metadata.md
TEST(WriteLine, WritesJson) {
  LineHead head;
  head.source = "gr\"o\\ß\n";
  head.algorithm = "csd";
  head.frame = 12;
  head.pts = 480000000;
  head.duration = 40000000;
  head.running_time = 1;
  head.stream_time = ~std::uint64_t{0} - 1;
  head.reference_caps = "timestamp/x-ntp";
  head.reference_time = 3;
  head.width = 640;
  head.height = 480;
  head.pixel_aspect_n = 16;
  head.pixel_aspect_d = 11;
  EXPECT_EQ(
      json(head, {{0, 311.2037, -0.0001, "tracked", 0.931}, {4294967294, nan, 1e9, "lost", 0, false}}),
      R"({"schema":1,"source":"gr\"o\\ß\u000a","role":"track","algorithm":"csd","frame":12,"pts":480000000,)"
      R"("duration":40000000,"running_time":1,"stream_time":18446744073709551614,"reference":{"caps":)"
      R"("timestamp/x-ntp","ns":3},"width":640,"height":480,"pixel_aspect":[16,11],"features":[{"id":0,"x":311.204,"y":0.000,"state":)"
      R"("tracked","confidence":0.931},{"id":4294967294,"x":null,"y":1000000000.000,"state":"lost",)"
      R"("confidence":0.000,"fresh":false}]})");
}

TEST(WriteLine, UnknownValuesAreNull) {
  EXPECT_EQ(json({}, {}),
            R"({"schema":1,"source":null,"role":"track","algorithm":null,"frame":null,"pts":null,"duration":null,)"
            R"("running_time":null,"stream_time":null,"reference":null,"width":null,"height":null,"features":[]})");
}

TEST(WriteLine, ReadLineReadsItBack) {
  LineHead head;
  head.role = "truth";
  head.source = "a\tb\"";
  head.frame = 7;
  head.stream_time = 5;
  head.width = head.height = 64;
  head.pixel_aspect_n = 4;
  head.pixel_aspect_d = 3;
  JsonText text;
  const TrackLine line = read_track_line(text, json(head, {{3, 1.5, 2.25, "occluded", 0.5, false}}));
  EXPECT_TRUE(line.truth && line.numbered);
  EXPECT_EQ(line.source, "a\tb\"");
  EXPECT_EQ(line.pts, no_time);
  EXPECT_EQ(line.stream_time, 5);
  EXPECT_EQ(std::pair(line.pixel_aspect_n, line.pixel_aspect_d), std::pair(4, 3));
  ASSERT_EQ(line.tracks.features.size(), 1u);
  const Feature &feature = line.tracks.features[0];
  EXPECT_EQ(std::tuple(feature.id, feature.x, feature.y, feature.state, feature.confidence, feature.fresh),
            std::tuple(3u, 1.5, 2.25, FeatureState::occluded, 0.5, false));
}

TEST(WriteLine, WritesCsv) {
  if (!std::setlocale(LC_ALL, "de_DE.UTF-8")) GTEST_SKIP() << "no locale de_DE.UTF-8 here";
  LineHead head;
  head.frame = 12;
  head.stream_time = 48;
  std::string out(csv_header);
  CsvRows rows(out, head);
  rows.add({0, 1.5, nan, "tracked", 0.931});
  rows.add({1, 2, 3, "of, \"others\"", 0, false});
  std::setlocale(LC_ALL, "C");
  EXPECT_EQ(out,
            "frame,pts,stream_time,id,x,y,state,confidence,fresh\n"
            "12,,48,0,1.500,,tracked,0.931,true\n"
            "12,,48,1,2.000,3.000,\"of, \"\"others\"\"\",0.000,false\n");
}

}  // namespace
}  // namespace csd
