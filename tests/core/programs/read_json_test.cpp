// SPDX-License-Identifier: LGPL-2.1-or-later
#include "programs/read_json.h"

#include <gmock/gmock.h>

#include "programs/input_text.h"

namespace csd::programs {
namespace {

using score::Presence;
using testing::ElementsAre;
using testing::HasSubstr;

/// A line as csdtrackenc writes it.
std::string line(const std::string &role, int frame, const std::string &features, const std::string &algorithm = "lk") {
  return R"({"schema":1,"source":"csdtrack0","role":")" + role + R"(","algorithm":")" + algorithm + R"(","frame":)" +
         std::to_string(frame) + R"(,"pts":)" + std::to_string(frame * 40000000ll) +
         R"(,"duration":40000000,"running_time":7,"stream_time":5,"reference":null,"width":640,"height":480,"features":[)" +
         features + "]}\n";
}

std::string feature(int id, const std::string &state = "tracked", const std::string &confidence = "0.931") {
  return R"({"id":)" + std::to_string(id) + R"(,"x":311.204,"y":187,"state":")" + state + R"(","confidence":)" +
         confidence + "}";
}

TEST(Jsonl, ReadsTracksAsCsdtrackencWritesThem) {
  // Includes a line without metadata, and members and states without meaning here.
  const auto tracks = read<score::Recording>(
      R"({"schema":1,"source":null,"role":"track","algorithm":null,"frame":null,"pts":null,"width":640,"height":480,"features":[]})"
      "\n" +
      line("track", 0, feature(0) + "," + feature(7, "lost", "0")) +
      line("track", 1, feature(0) + "," + feature(7, "lost", "0")));
  EXPECT_EQ(tracks.algorithm, "lk");
  EXPECT_EQ(tracks.width, 640);
  EXPECT_EQ(tracks.height, 480);
  EXPECT_FALSE(tracks.sparse);
  ASSERT_EQ(tracks.frames.size(), 3u);
  EXPECT_FALSE(tracks.frames[0].numbered);
  EXPECT_EQ(tracks.frames[0].pts, no_time);
  EXPECT_TRUE(tracks.frames[1].numbered);
  EXPECT_EQ(tracks.frames[2].frame, 1u);
  EXPECT_EQ(tracks.frames[2].pts, 40000000);
  EXPECT_EQ(tracks.frames[2].stream_time, 5);
  EXPECT_EQ(tracks.frames[2].running_time, 7);
  EXPECT_EQ(tracks.frames[2].line, 3u);
  ASSERT_EQ(tracks.frames[1].features.size(), 2u);
  EXPECT_EQ(tracks.frames[1].features[0].x, 311.204);
  EXPECT_EQ(tracks.frames[1].features[0].y, 187);
  EXPECT_EQ(tracks.frames[1].features[0].confidence, .931);
  EXPECT_EQ(tracks.frames[1].features[1].id, 7u);
  EXPECT_EQ(tracks.frames[1].features[1].state, FeatureState::lost);
}

TEST(Jsonl, NotesAFrameThatLacksItsFeatures) {
  std::vector<std::string> notes;
  read<score::Recording>(line("track", 0, feature(0)) + line("track", 1, "") + line("track", 2, feature(0)), &notes);
  EXPECT_THAT(notes, ElementsAre(HasSubstr(":2: from frame 1 on, 1 feature is absent")));
}

TEST(Jsonl, ReadsTruth) {
  const auto truth = read<score::Truth>(line("truth", 0, feature(0) + "," + feature(1)) + line("truth", 1, "") +
                                        line("truth", 2, feature(0, "occluded", "0") + "," + feature(2, "out", "0")));
  EXPECT_THAT(truth.ids, ElementsAre(0u, 1u, 2u));
  EXPECT_EQ(truth.height, 480);
  ASSERT_EQ(truth.frames.size(), 2u) << "frame 1 labels nothing";
  EXPECT_EQ(truth.frames[0].points[1].presence, Presence::visible);
  EXPECT_EQ(truth.frames[0].points[2].presence, Presence::unlabelled);
  EXPECT_EQ(truth.frames[1].pts, 80000000);
  EXPECT_EQ(truth.frames[1].line, 3u);
  EXPECT_EQ(truth.frames[1].points[0].presence, Presence::hidden);
  EXPECT_EQ(truth.frames[1].points[0].position, cv::Point2d(311.204, 187));
  EXPECT_EQ(truth.frames[1].points[2].presence, Presence::out);
}

TEST(Jsonl, DropsATornLastLineWithANote) {
  std::vector<std::string> notes;
  const std::string torn = line("track", 1, feature(0)).substr(0, 100);
  EXPECT_EQ(read<score::Recording>(line("track", 0, feature(0)) + torn, &notes).frames.size(), 1u);
  EXPECT_THAT(notes, ElementsAre(HasSubstr(":2: the last line has no newline")));
}

TEST(Jsonl, NamesEachDefect) {
  const std::string good = line("track", 0, feature(0));
  const auto with = [&](const std::string &from, const std::string &to) {
    std::string bad = line("track", 1, feature(0));
    bad.replace(bad.find(from), from.size(), to);
    return error_of(good + bad);
  };
  EXPECT_THAT(with("\"id\"", "id"), HasSubstr(":2: is no JSON"));
  EXPECT_EQ(with("\"schema\":1", "\"schema\":2"), ":2: schema 2 is not known (1 is)");
  EXPECT_EQ(with("\"schema\":1,", ""), ":2: has no `schema`");
  EXPECT_EQ(with("\"frame\":1", "\"frame\":-1"), ":2: `frame` is no whole number from 0");
  EXPECT_EQ(with("\"frame\":1", "\"frame\":1.5"), ":2: `frame` is no whole number from 0");
  EXPECT_EQ(with("\"frame\":1", "\"frame\":null"), ":2: has features, but no `frame`");
  EXPECT_EQ(with("\"pts\":40000000", "\"pts\":\"now\""), ":2: `pts` is no whole number from 0");
  EXPECT_EQ(with("\"x\":311.204", "\"x\":null"), ":2: `x` is no number");
  EXPECT_EQ(with("\"x\":311.204,", ""), ":2: `x` is no number");
  EXPECT_EQ(with("tracked", "seen"), ":2: there is no state 'seen'");
  EXPECT_EQ(with("0.931", "1.01"), ":2: a confidence is from 0 to 1");
  EXPECT_EQ(with("\"id\":0", "\"id\":4294967295"), ":2: `id` is no whole number from 0 to 4294967294");
  EXPECT_EQ(with("\"id\":0,", ""), ":2: a feature has no `id`");
  EXPECT_EQ(with("\"features\":[", "\"features\":[1,"), ":2: a feature is no object");
  EXPECT_EQ(with("\"role\":\"track\"", "\"role\":\"truth\""), ":2: `role` is truth, in the lines before it is track");
  EXPECT_EQ(with("\"role\":\"track\"", "\"role\":\"other\""), ":2: `role` is 'other', neither track nor truth");
  EXPECT_EQ(with("\"lk\"", "\"ms1\""), ":2: is by ms1, the lines before by lk");
  EXPECT_EQ(error_of(line("track", 0, feature(3) + "," + feature(2))), ":1: feature 2 after feature 3");
  EXPECT_EQ(error_of(line("truth", 0, feature(0, "lost"))),
            ":1: a truth's states are tracked, occluded and out, not lost");
  EXPECT_EQ(error_of(good + "[]\n"), ":2: is no JSON object");
  EXPECT_THAT(error_of("{\"schema\":1,\n"), HasSubstr(":1: is no JSON"));
}

TEST(Labels, ReadsThoseOfVlSurgPt) {
  const auto truth = read<score::Truth>(R"({"30": [[10, 528], [952.5, 604]], "60": [null, [1044, 442]],
    "90": null, "175": [null, null], "0": [[11, 20], [951, 604]]})");
  EXPECT_THAT(truth.ids, ElementsAre(0u, 1u));
  ASSERT_EQ(truth.frames.size(), 4u) << "90 is not labelled";
  EXPECT_EQ(truth.frames[0].frame, 0u);
  EXPECT_EQ(truth.frames[1].frame, 30u);
  EXPECT_EQ(truth.frames[1].points[1].position, cv::Point2d(952.5, 604));
  EXPECT_EQ(truth.frames[2].points[0].presence, Presence::hidden);
  EXPECT_TRUE(std::isnan(truth.frames[2].points[0].position.x));
  EXPECT_EQ(truth.frames[3].frame, 175u);
  EXPECT_EQ(truth.width, 0) << "the file doesn't say";
}

TEST(Labels, NamesEachDefect) {
  EXPECT_EQ(error_of(R"({"0": [[1, 2]], "30": [[1, 2], [3, 4]]})"), ": frame 30: has 2 points, the frame before has 1");
  EXPECT_EQ(error_of(R"({"0": [[1]]})"), ": frame 0: point 0 is neither [x, y] nor null");
  EXPECT_EQ(error_of(R"({"0": [{"status": ["visible"]}]})"), ": frame 0: point 0 is neither [x, y] nor null")
      << "texts.json, which lies beside it";
  EXPECT_EQ(error_of(R"({"0": 5})"), ": frame 0: is no list of points");
  EXPECT_THAT(error_of(R"({"frames": []})"), HasSubstr("'frames' is no frame number"));
  EXPECT_EQ(error_of(R"({})"), ": labels nothing");
  EXPECT_THAT(error_of(R"({"0": [[1, 2]])"), HasSubstr(": is no JSON"));
  const std::string begins(1000000, '['), ends(1000000, ']');
  EXPECT_EQ(error_of("{\"0\": " + begins + ends + "}"), ": is no JSON: brackets are nested more than 16 deep");
  EXPECT_THAT(error_of("{\"0\": " + begins), HasSubstr(": is no JSON: "));
  std::string many = R"({"0": [[1, 2])";
  for (int i = 0; i < 1 << 20; ++i) many += ",[1,2]";
  EXPECT_EQ(error_of(many + "]}"), ": holds more than 2097152 values") << "they would fill the memory";
}

}  // namespace
}  // namespace csd::programs
