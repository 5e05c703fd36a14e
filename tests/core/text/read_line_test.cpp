// SPDX-License-Identifier: LGPL-2.1-or-later
#include "text/read_line.h"

#include <gmock/gmock.h>

namespace csd {
namespace {

constexpr char wrong[] =
    "is no JSON: a value is misspelt or too large, or a bracket, comma or colon is not where one belongs";
constexpr char escape[] = "is no JSON: a wrong escape in a string, or half a surrogate pair";
constexpr char deep[] = "is no JSON: brackets are nested more than 16 deep";

constexpr char line[] =
    R"({"schema":1,"source":"größe \"0\"","role":"track","algorithm":"csd","frame":12,"pts":480000000,)"
    R"("duration":40000000,"running_time":1,"stream_time":520000000,"reference":{"caps":"timestamp/x-ntp","ns":3900000000000000001},)"
    R"("width":640,"height":480,"new":[[{"a":[1]}]],"features":[)"
    R"({"id":0,"x":311.204,"y":-1,"state":"tracked","confidence":0.931},)"
    R"({"id":4294967294,"x":0.000,"y":1e2,"state":"lost","confidence":0,"fresh":false}]})";

TrackLine read(const std::string &text) {
  JsonText json;
  return read_track_line(json, text);
}

std::string error_of(const std::string &text) {
  try {
    read(text);
  } catch (const LineError &error) {
    return error.what();
  }
  return "none";
}

/// The error for the line with `from` replaced.
std::string with(const std::string &from, const std::string &to) {
  std::string bad = line;
  bad.replace(bad.find(from), from.size(), to);
  return error_of(bad);
}

TEST(ReadLine, HoldsWhatCsdtrackencWrites) {
  const TrackLine read_line = read(line);
  EXPECT_FALSE(read_line.truth);
  EXPECT_EQ(read_line.source, "größe \"0\"");
  EXPECT_EQ(read_line.algorithm, "csd");
  EXPECT_TRUE(read_line.numbered);
  EXPECT_EQ(read_line.pts, 480000000);
  EXPECT_EQ(read_line.duration, 40000000);
  EXPECT_EQ(read_line.stream_time, 520000000);
  const Tracks &tracks = read_line.tracks;
  EXPECT_EQ(tracks.frame, 12u);
  EXPECT_EQ(tracks.width, 640);
  EXPECT_EQ(tracks.height, 480);
  ASSERT_EQ(tracks.features.size(), 2u);
  EXPECT_EQ(tracks.features[0].x, 311.204);
  EXPECT_EQ(tracks.features[0].y, -1);
  EXPECT_EQ(tracks.features[0].confidence, .931);
  EXPECT_EQ(tracks.features[0].state, FeatureState::tracked);
  EXPECT_TRUE(tracks.features[0].fresh);
  EXPECT_EQ(tracks.features[1].id, 4294967294u);
  EXPECT_EQ(tracks.features[1].y, 100);
  EXPECT_EQ(tracks.features[1].state, FeatureState::lost);
  EXPECT_FALSE(tracks.features[1].fresh);
}

TEST(ReadLine, HoldsTheShapeOfThePixels) {
  EXPECT_EQ(read(line).pixel_aspect_n, 0) << "older lines don't say";
  EXPECT_EQ(read(line).pixel_aspect_d, 0);
  std::string shaped = line;
  shaped.insert(shaped.find(R"("new")"), R"("pixel_aspect":[16,11],)");
  EXPECT_EQ(read(shaped).pixel_aspect_n, 16);
  EXPECT_EQ(read(shaped).pixel_aspect_d, 11);
  std::string null = line;
  null.insert(null.find(R"("new")"), R"("pixel_aspect":null,)");
  EXPECT_EQ(read(null).pixel_aspect_n, 0);
  for (const char *bad : {"[]", "[1]", "[1,1,1]", "[0,1]", "[1,0]", "[-1,1]", "[1,1.5]", "[1,\"1\"]", "[1048577,1]",
                          "\"1:1\"", "1", "{}", "[[1,1]]"})
    EXPECT_THAT(with(R"("new")", std::string(R"("pixel_aspect":)") + bad + R"(,"new")"),
                testing::HasSubstr("`pixel_aspect` is no"))
        << bad;
}

TEST(ReadLine, NullMeansUnknown) {
  const TrackLine bare = read(
      R"({"schema":1,"source":null,"role":"truth","algorithm":null,"frame":null,"pts":null,"stream_time":null,"features":[]})");
  EXPECT_TRUE(bare.truth);
  EXPECT_EQ(bare.source, "");
  EXPECT_FALSE(bare.numbered);
  EXPECT_EQ(bare.pts, no_time);
  EXPECT_EQ(bare.duration, no_time);
  EXPECT_EQ(bare.stream_time, no_time);
  EXPECT_EQ(bare.tracks.width, 0);
}

TEST(ReadLine, NamesEachDefect) {
  EXPECT_EQ(with("1e2", "1e9"), "`y` is beyond 1048576 pixels");
  EXPECT_EQ(with("1e2", "\"1\""), "`y` is no number");
  EXPECT_EQ(with("4294967294", "4294967295"), "`id` is no whole number from 0 to 4294967294");
  EXPECT_EQ(with("4294967294", "-1"), "`id` is no whole number from 0 to 4294967294");
  EXPECT_EQ(with("4294967294", "0"), "feature 0 after feature 0");
  EXPECT_EQ(with("false", "0"), "`fresh` is neither true nor false");
  EXPECT_EQ(with("520000000", "-520000000"), "`stream_time` is no whole number from 0");
  EXPECT_EQ(with("520000000", "9223372036854775808"), "`stream_time` is no whole number from 0 to 9223372036854775807");
  EXPECT_EQ(with("520000000", "-9223372036854775808"), "`stream_time` is no whole number from 0");
  EXPECT_EQ(with("520000000", "4611686018427387903"), "none");
  EXPECT_EQ(with("520000000", "4611686018427387904"), "`stream_time` is more than 146 years");
  for (const char *from : {"\"width\":640,", "\"height\":480,"})
    EXPECT_EQ(with(from, ""), "has no `width` or no `height`");
  EXPECT_EQ(with("640", "0"), "has no `width` or no `height`");
  EXPECT_EQ(with("\"height\":480", "\"height\":null"), "has no `width` or no `height`");
  EXPECT_EQ(with("640", "1048577"), "`width` is no whole number from 0 to 1048576");
  EXPECT_EQ(with("größe", std::string(1001, 'x')), "`source` is longer than 1000 bytes");
  EXPECT_EQ(with("\"track\"", "\"truth\""), "a truth's states are tracked, occluded and out, not lost");
  EXPECT_EQ(with("\"features\"", "\"future\""), "`features` is no array");
  for (const char *name : {"csd", "größe"})
    EXPECT_THAT(with(name, "c\\u0000d"), testing::EndsWith("` holds a character 0")) << name;
  EXPECT_EQ(with("\"lost", "\"lost\\u0000"), "`state` holds a character 0");
}

// Other readers misread each of these, or crash.
TEST(ReadLine, RefusesInvalidJson) {
  for (const char *bad : {"99999999999999999999", "-99999999999999999999", "-9223372036854775809", "1e999", "-1e999",
                          "012", "-", "--1", "1.", "1e", "1.e2", "0x12", "-Infinity", "1_000"}) {
    EXPECT_EQ(with("1e2", bad), wrong) << bad;
    EXPECT_EQ(with("3900000000000000001", bad), wrong) << bad << " in a field that is not read";
  }
  for (const char *bad : {".5",   "+1",    "NaN", "Infinity", "'1'",  "/*13*/12", "{1:2}", "{a:2}", "{\"a\"}", "[1,,2]",
                          "[1,]", "[1 2]", "[1}", "1}",       "\x01", "",         "tru",   "truee", "nul",     "fals"})
    EXPECT_EQ(with("3900000000000000001", bad), wrong) << bad;
  EXPECT_EQ(with("1e2", std::string(5000, '5')), wrong);
  EXPECT_EQ(with("1e2", "9223372036854775808.5"), "`y` is beyond 1048576 pixels");
  EXPECT_EQ(with("1e2", "1e-999"), "none") << "it is 0";
  EXPECT_EQ(error_of(std::string(line) + line), wrong);
  EXPECT_EQ(error_of(std::string(line) + " x"), wrong);
  EXPECT_EQ(error_of(std::string(line) + '\0'), wrong);
  EXPECT_EQ(error_of("var x = " + std::string(line)), wrong);
  EXPECT_EQ(error_of(std::string("{\0}", 3)), wrong);
  EXPECT_EQ(error_of("{\"schema\":1"), wrong);
  EXPECT_EQ(error_of("{\"schema"), "is no JSON: a string has no end");
  EXPECT_EQ(error_of("\xef\xbb\xbf" + std::string(line)), "is no JSON: a byte order mark");
  EXPECT_EQ(error_of(""), "is no JSON: it is empty");
  EXPECT_EQ(error_of(" \t\r"), "is no JSON: it is empty");
  EXPECT_EQ(error_of("1"), "is no JSON object");
}

TEST(ReadLine, RefusesTextThatIsNotUtf8) {
  for (const char *bad : {"\xf6", "\xc0\xaf", "\xed\xa0\x80", "\xf4\x90\x80\x80", "\xc3"})
    EXPECT_EQ(with("größe", bad), "is no JSON: it is not UTF-8") << "Latin-1, too long, half a pair, too large, torn";
  for (const char *bad : {"\\ud800", "\\udc00", "\\ud800\\ud800", "\\ud800x", "\\x41", "\\u12", "\\u12g4"}) {
    EXPECT_EQ(with("csd", bad), escape) << bad;
    EXPECT_EQ(with("new", bad), escape) << bad << " in a name";
  }
  EXPECT_EQ(read(std::string(line).replace(std::string(line).find("csd"), 3, "\\ud83d\\ude00")).algorithm, "😀");
  for (const char *bad : {"\n", "\x01", "\x1f"})
    EXPECT_EQ(with("größe", bad), "is no JSON: a control character in a string");
  std::string zero = line;
  zero[zero.find("csd")] = '\0';
  EXPECT_EQ(error_of(zero), "is no JSON: a control character in a string");
}

TEST(ReadLine, LimitsTheDepthOfBrackets) {
  const auto nested = [](std::size_t depth) { return std::string(depth, '[') + "1" + std::string(depth, ']'); };
  EXPECT_EQ(with("[[{\"a\":[1]}]]", nested(15)), "none");
  EXPECT_EQ(with("[[{\"a\":[1]}]]", nested(16)), deep);
  EXPECT_EQ(with("[[{\"a\":[1]}]]", nested(3000000)), deep);
  EXPECT_EQ(with("[[{\"a\":[1]}]]", std::string(3000000, '[')), deep);
  EXPECT_EQ(error_of(std::string(3000000, '[')), wrong);
  EXPECT_EQ(error_of("{\"a\":" + std::string(3000000, '[')), wrong);
}

TEST(ReadLine, TakesTheLastOfMembersOfOneName) {
  const std::string twice =
      R"({"role":"other","schema":2,"width":1,"height":1,"frame":7,"features":7,"algorithm":"lk",)";
  const TrackLine read_line = read(twice + std::string(line).substr(1));
  EXPECT_EQ(read_line.algorithm, "csd");
  EXPECT_EQ(read_line.tracks.frame, 12u);
  EXPECT_EQ(read_line.tracks.width, 640);
  EXPECT_EQ(with("\"new\"", "\"source\":null,\"source\""), "`source` is no string");
  EXPECT_EQ(read(std::string(line).replace(std::string(line).find("\"new\""), 5, "\"pts\":null,\"n\"")).pts, no_time);
}

TEST(ReadLine, TakesMembersInAnyOrder) {
  const TrackLine read_line = read(
      R"({"features":[{"fresh":false,"confidence":0.5,"more":[1],"state":"out","y":2,"x":1,"id":3}],"stream_time":9,)"
      R"("height":480,"width":640,"duration":8,"pts":7,"frame":6,"algorithm":"a","source":"s","role":"track","schema":1})");
  EXPECT_EQ(read_line.source, "s");
  EXPECT_EQ(read_line.algorithm, "a");
  EXPECT_EQ(read_line.pts, 7);
  EXPECT_EQ(read_line.duration, 8);
  EXPECT_EQ(read_line.stream_time, 9);
  const Tracks &tracks = read_line.tracks;
  EXPECT_EQ(tracks.frame, 6u);
  ASSERT_EQ(tracks.features.size(), 1u);
  EXPECT_EQ(tracks.features[0].id, 3u);
  EXPECT_EQ(tracks.features[0].x, 1);
  EXPECT_EQ(tracks.features[0].y, 2);
  EXPECT_EQ(tracks.features[0].state, FeatureState::out);
  EXPECT_EQ(tracks.features[0].confidence, 0.5);
  EXPECT_FALSE(tracks.features[0].fresh);
}

TEST(ReadLine, ReadsTheNextLineAfterAWrongOne) {
  JsonText json;
  EXPECT_THROW(read_track_line(json, "{"), LineError);
  EXPECT_EQ(read_track_line(json, line).tracks.features.size(), 2u);
  EXPECT_THROW(read_track_line(json, std::string(100000, '[') + std::string(100000, ']')), LineError);
  EXPECT_EQ(read_track_line(json, line).tracks.features.size(), 2u);
}

TEST(ReadLine, RefusesInputThatWouldFillTheMemory) {
  std::string many = R"({"schema":1,"role":"track","frame":0,"width":640,"height":480,"features":[)";
  for (int i = 0; i < 65537; ++i) {
    if (i > 0) many += ',';
    many += R"({"id":)";
    many += std::to_string(i);
    many += R"(,"x":0,"y":0,"state":"out","confidence":0})";
  }
  EXPECT_EQ(error_of(many + "]}"), "has more than 65536 features");
  many.erase(many.rfind(",{\"id\":65536"));
  EXPECT_EQ(read(many + "]}").tracks.features.size(), 65536u);
  std::string list = "{\"a\":[0";
  for (int i = 0; i < 600000; ++i) list += ",0";
  EXPECT_EQ(error_of(list + "]}"), "holds more than 524288 values");
  EXPECT_EQ(error_of(std::string(line) + std::string(8 << 20, ' ')), "is longer than 8 MiB");
}

TEST(LineText, DropsTheByteOrderMarkAndTrailingBlanksAndNuls) {
  EXPECT_EQ(line_text("{ }"), "{ }");
  EXPECT_EQ(line_text("\xef\xbb\xbf{}\r\n"), "{}");
  EXPECT_EQ(line_text(" {} \t\r\n"), " {}");
  EXPECT_EQ(line_text({"{}\0\0\n", 5}), "{}");
  EXPECT_EQ(line_text({"\0{}\0", 4}), (std::string_view{"\0{}", 3})) << "a leading NUL is kept, and is no JSON";
  EXPECT_EQ(line_text({" \t\r\n\0", 5}), "");
  EXPECT_EQ(line_text("\xef\xbb\xbf"), "");
  EXPECT_EQ(line_text(""), "");
}

TEST(Printable, ControlCharactersAreReplaced) {
  EXPECT_EQ(printable("größe 'a' {b}"), "größe 'a' {b}");
  EXPECT_EQ(printable("a\nb\r\t\x1b[2J\x7f"), "a?b???[2J?") << "line feed, escape, delete";
  EXPECT_EQ(printable("a\xc2\x9b"
                      "2Jb\xc2\xa0\xc2"),
            "a?2Jb\xc2\xa0\xc2")
      << "UTF-8's start of escape sequences; a non-breaking space";
}

}  // namespace
}  // namespace csd
