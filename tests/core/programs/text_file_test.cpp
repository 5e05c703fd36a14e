// SPDX-License-Identifier: LGPL-2.1-or-later
#include "programs/text_file.h"

#include <gmock/gmock.h>

#include "programs/file.h"
#include "score/types.h"
#include "text/read_line.h"

namespace csd::programs {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

TEST(TextFile, GivesWholeLinesWithTheirNumbers) {
  const TestFolder folder;
  const TextFile file = read_text_file(folder.write("f",
                                                    "\xef\xbb\xbf"
                                                    "one\r\n\nthree\nfo"));
  const auto lines = file.lines();
  ASSERT_EQ(lines.size(), 2u) << "without the empty and the torn one";
  EXPECT_EQ(lines[0].number, 1u);
  EXPECT_EQ(lines[0].text, "one");
  EXPECT_EQ(lines[1].number, 3u);
  EXPECT_EQ(lines[1].text, "three");
  std::vector<std::string> notes;
  note_torn(file, notes);
  EXPECT_THAT(notes, ElementsAre(HasSubstr("f:4: the last line has no newline")));
}

TEST(TextFile, TheFirstLineIsTheFirstNonEmptyOne) {
  const TestFolder folder;
  const TextFile blank = read_text_file(folder.write("f", std::string("\r\n\0\0\n \none\ntwo\n", 15)));
  EXPECT_EQ(blank.first().number, 4u);
  EXPECT_EQ(blank.first().text, "one");
  EXPECT_EQ(blank.lines().size(), 2u);
  EXPECT_EQ(read_text_file(folder.write("torn", "one")).first().text, "one");
}

TEST(TextFile, AWholeFileHasNoNote) {
  const TestFolder folder;
  std::vector<std::string> notes;
  note_torn(read_text_file(folder.write("f", "one\n")), notes);
  EXPECT_THAT(notes, IsEmpty());
}

TEST(TextFile, RefusesALongLineBeforeItFillsTheMemory) {
  const TestFolder folder;
  const std::string longest(max_line_bytes, 'x');
  EXPECT_EQ(read_text_file(folder.write("longest", longest + "\n" + longest)).lines().size(), 1u);
  try {
    read_text_file(folder.write("longer", "one\n" + longest + "xy\n"));
    ADD_FAILURE() << "the long line is accepted";
  } catch (const score::InputError &error) {
    EXPECT_THAT(error.what(), HasSubstr("longer:2: is longer than 8 MiB"));
  }
}

}  // namespace
}  // namespace csd::programs
