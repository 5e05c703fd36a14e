// SPDX-License-Identifier: LGPL-2.1-or-later
#include "text/read_line.h"

#include <gmock/gmock.h>

namespace csd {
namespace {

using testing::AllOf;
using testing::AnyOf;
using testing::HasSubstr;
using testing::StartsWith;

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
  EXPECT_EQ(with("1e2", "1e999"), "`y` is no number");
  EXPECT_EQ(with("1e2", "\"1\""), "`y` is no number");
  EXPECT_THAT(with("1e2", "NaN"), StartsWith("is no JSON: "));
  EXPECT_THAT(with("1e2", "-Infinity"), StartsWith("is no JSON: "));
  EXPECT_EQ(with("4294967294", "4294967295"), "`id` is no whole number from 0 to 4294967294");
  EXPECT_EQ(with("4294967294", "-1"), "`id` is no whole number from 0 to 4294967294");
  EXPECT_EQ(with("4294967294", "0"), "feature 0 after feature 0");
  EXPECT_EQ(with("false", "0"), "`fresh` is neither true nor false");
  EXPECT_EQ(with("520000000", "-520000000"), "`stream_time` is no whole number from 0");
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
  EXPECT_THAT(with("größe",
                   "gr\xf6\xdf"
                   "e"),
              StartsWith("is no JSON: "))
      << "Latin-1";
  const std::string half_a_pair = with("größe \\\"0\\\"", "\\ud800");
  // From 1.10 on, json-glib itself refuses it.
  const auto refuses_half = [](const char *field) {
    return AnyOf("`" + std::string(field) + "` holds half a character",
                 AllOf(StartsWith("is no JSON: "), HasSubstr("surrogate")));
  };
  EXPECT_THAT(with("csd", "c\\ud800d"), refuses_half("algorithm"));
  EXPECT_THAT(with("\"lost", "\"lo\\udc00st"), refuses_half("state"));
  EXPECT_TRUE(g_utf8_validate(half_a_pair.c_str(), -1, nullptr)) << half_a_pair;
}

// json-glib would misread each of these, or crash.
TEST(ReadLine, RefusesInvalidJson) {
  EXPECT_EQ(with("12,", "99999999999999999999,"), "is no JSON: a number has more than 19 digits");
  EXPECT_EQ(with("-1,", "-99999999999999999999,"), "is no JSON: a number has more than 19 digits");
  EXPECT_EQ(with("480000000", "9223372036854775807"), "none");
  EXPECT_EQ(with("520000000", "9223372036854775808"), "is no JSON: a whole number of more than 64 bits");
  EXPECT_EQ(with("520000000", "-9223372036854775809"), "is no JSON: a whole number of more than 64 bits");
  EXPECT_EQ(with("520000000", "-9223372036854775808"), "`stream_time` is no whole number from 0");
  EXPECT_EQ(with("1e2", "9223372036854775808"), "is no JSON: a whole number of more than 64 bits");
  EXPECT_EQ(with("1e2", "9223372036854775808.5"), "`y` is beyond 1048576 pixels");
  EXPECT_EQ(with("12,", "012,"), "is no JSON: a number begins with 0");
  EXPECT_EQ(with("12,", "0x12,"), "is no JSON: unexpected character 'x'");
  EXPECT_EQ(with("12,", "/*13*/12,"), "is no JSON: unexpected character '/'");
  EXPECT_EQ(with("\"csd\"", "'csd'"), "is no JSON: unexpected character '''");
  EXPECT_EQ(with("größe", "\n"), "is no JSON: a control character in a string");
  EXPECT_EQ(error_of(std::string(line) + line), "is no JSON: there is more behind the object");
  EXPECT_EQ(error_of("var x = " + std::string(line)), "is no JSON: unexpected character 'v'");
  EXPECT_EQ(error_of(std::string(3000000, '[')), "is no JSON: brackets are nested more than 16 deep");
  EXPECT_EQ(error_of("{\"a\":" + std::string(3000000, '[')), "is no JSON: brackets are nested more than 16 deep");
  EXPECT_EQ(with("[[{\"a\":[1]}]]", std::string(15, '[') + std::string(15, ']')), "none");
  EXPECT_EQ(with("[[{\"a\":[1]}]]", std::string(16, '[') + std::string(16, ']')),
            "is no JSON: brackets are nested more than 16 deep");
  EXPECT_EQ(error_of(""), "is no JSON: it is empty");
  EXPECT_EQ(error_of("1"), "is no JSON object");
  EXPECT_EQ(error_of(std::string("{\0}", 3)), "is no JSON: an unexpected character");
  EXPECT_THAT(error_of("{\"schema\":1"), StartsWith("is no JSON: "));
  EXPECT_THAT(error_of("{\"schema"), StartsWith("is no JSON: "));
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
